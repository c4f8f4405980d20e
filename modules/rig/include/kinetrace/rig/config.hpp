// Settings of the refinement of a rig's calibration while it is in use.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <string_view>

#include "kinetrace/core/export.hpp"
#include "kinetrace/core/result.hpp"

namespace kinetrace::rig {

enum class RefineMode : std::uint8_t {
  kOff,
  kCheck,  ///< Estimates and reports, applies no correction.
  kOn,     ///< Applies the certain part of the correction.
};
inline constexpr std::array<std::string_view, 3> kRefineModeNames{"off", "check", "on"};

[[nodiscard]] constexpr std::string_view to_string(RefineMode mode) noexcept {
  return kRefineModeNames.at(static_cast<std::size_t>(mode));
}
[[nodiscard]] constexpr bool from_string(std::string_view text, RefineMode& mode) noexcept {
  for (std::size_t i = 0; i < kRefineModeNames.size(); ++i) {
    if (kRefineModeNames.at(i) == text) {
      mode = static_cast<RefineMode>(i);
      return true;
    }
  }
  return false;
}

struct KINETRACE_API RefineConfig {
  RefineMode mode = RefineMode::kOn;
  int max_features = 1600;  ///< Slots of the feature front end.
  int max_points = 120;     ///< Points of a pair of frames; more add time, but little information.
  /// Prior standard deviation of the right camera's angles and of the baseline's direction.
  double prior_sigma_deg = 1.0;
  /// Correlated error of a match, px, from contours and lenses: a lower bound of the estimate's error.
  double bias_px = 0.02;

  [[nodiscard]] Status validate() const;
};

}  // namespace kinetrace::rig
