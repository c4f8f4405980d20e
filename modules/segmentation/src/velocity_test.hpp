// When two velocities may be the same.
#pragma once

#include <Eigen/Core>

namespace kinetrace::segmentation {

/// 99 % of three normal variables squared.
inline constexpr float kSameVelocityChi2 = 11.3F;

/// d^T C^-1 d for symmetric positive definite C, by L D L^T: four divisions, no matrix is inverted.
[[nodiscard]] inline float mahalanobis_sq(const Eigen::Vector3f& d, const Eigen::Matrix3f& c) {
  const float l10 = c(1, 0) / c(0, 0);
  const float l20 = c(2, 0) / c(0, 0);
  const float d1 = c(1, 1) - l10 * c(1, 0);
  const float l21 = (c(2, 1) - l20 * c(1, 0)) / d1;
  const float d2 = c(2, 2) - l20 * c(2, 0) - l21 * l21 * d1;
  const float y1 = d.y() - l10 * d.x();
  const float y2 = d.z() - l20 * d.x() - l21 * y1;
  return d.x() * d.x() / c(0, 0) + y1 * y1 / d1 + y2 * y2 / d2;
}

/// Features of one object may differ by this because it turns, and because a fit assumes a constant velocity.
[[nodiscard]] inline Eigen::Matrix3f velocity_slack(const Eigen::Vector3f& velocity_mps) {
  const float sigma_mps = 0.3F + 0.1F * velocity_mps.norm();
  return sigma_mps * sigma_mps * Eigen::Matrix3f::Identity();
}

}  // namespace kinetrace::segmentation
