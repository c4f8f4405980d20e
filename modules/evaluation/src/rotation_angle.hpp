// The angle of a rotation.
#pragma once

#include <numbers>

#include "kinetrace/core/se3.hpp"

namespace kinetrace::evaluation {

inline constexpr double kDegPerRad = 180.0 / std::numbers::pi;

/// In [0, 180]; by atan2, which is accurate for small angles, unlike acos of the trace.
[[nodiscard]] inline double rotation_angle_deg(const Eigen::Matrix3d& rotation) {
  return so3_log(rotation).norm() * kDegPerRad;
}

}  // namespace kinetrace::evaluation
