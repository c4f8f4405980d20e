// Lens models for estimation, and unprojection from a pixel to its ray.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <string_view>
#include <utility>

#include <Eigen/Core>

#include "kinetrace/hal/rig_calibration.hpp"

namespace kinetrace::calibration {

/// Which distortion coefficients are free.
enum class Lens : std::uint8_t {
  kRadialTangential,   ///< k1 k2 p1 p2.
  kRadialTangential5,  ///< And k3.
  kRational,           ///< And k4 k5 k6.
  kFisheye,            ///< Equidistant, k1..k4.
};

inline constexpr std::array<std::pair<std::string_view, Lens>, 4> kLensNames{{{"radtan", Lens::kRadialTangential},
                                                                              {"radtan5", Lens::kRadialTangential5},
                                                                              {"rational", Lens::kRational},
                                                                              {"fisheye", Lens::kFisheye}}};

[[nodiscard]] constexpr int coefficient_count(Lens lens) noexcept {
  switch (lens) {
    case Lens::kRadialTangential: return 4;
    case Lens::kRadialTangential5: return 5;
    case Lens::kRational: return 8;
    case Lens::kFisheye: return 4;
  }
  return 4;
}

[[nodiscard]] constexpr hal::LensModel model_of(Lens lens) noexcept {
  return lens == Lens::kFisheye ? hal::LensModel::kEquidistant : hal::LensModel::kRadialTangential;
}

/// Direction (x/z, y/z) of a pixel; none where the lens model is not defined or not invertible.
[[nodiscard]] std::optional<Eigen::Vector2d> normalised_ray(const hal::CameraModel& camera, const Eigen::Vector2d& px);

}  // namespace kinetrace::calibration
