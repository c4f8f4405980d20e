// Checks of a solver's input.
#pragma once

#include <cstdint>
#include <span>

#include "kinetrace/core/bundle.hpp"
#include "kinetrace/core/result.hpp"

namespace kinetrace::refinement {

/// Bit mask of a window's frames.
[[nodiscard]] constexpr std::uint32_t frame_mask(std::size_t frames) noexcept {
  return frames >= kMaxWindowFrames ? ~0U : (1U << frames) - 1U;
}

[[nodiscard]] Status check_geometry(const StereoGeometry& geometry);
/// u_right may be NaN (not matched); everything else must be finite and the weight positive.
[[nodiscard]] bool is_valid(const BundleObservation& observation) noexcept;
/// Valid if empty or one per frame, all finite.
[[nodiscard]] Status check_turns(std::span<const TurnPrior> turns, std::size_t frames);
/// Checks sizes, gauge, and that every value in use is finite. An empty window is valid.
[[nodiscard]] Status check_window(const BundleWindow& window);

}  // namespace kinetrace::refinement
