// Tests for equality of velocities, and covariances for them.
#pragma once

#include <cmath>

#include <Eigen/Core>
#include <Eigen/Eigenvalues>

namespace kinetrace::segmentation {

/// 99 % quantile of chi-square with three degrees of freedom.
inline constexpr float kSameVelocityChi2 = 11.3F;

/// d^T C^-1 d for symmetric positive definite C, by L D L^T: four divisions instead of an inversion.
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

/// Squared Mahalanobis distance from `v` to the nearest velocity of at most `radius`: min over |u| <= radius of
/// (v - u)^T C^-1 (v - u).
[[nodiscard]] inline float distance_to_ball_sq(const Eigen::Vector3f& v, const Eigen::Matrix3f& c, float radius) {
  if (v.squaredNorm() <= radius * radius) {
    return 0.F;
  }
  Eigen::SelfAdjointEigenSolver<Eigen::Matrix3f> eigen;
  eigen.computeDirect(c);
  const Eigen::Vector3f w = eigen.eigenvectors().transpose() * v;
  const Eigen::Vector3f variance = eigen.eigenvalues().cwiseMax(1e-9F);
  // u_i = w_i / (1 + lambda c_i) with |u| = radius: Newton on 1 / |u| - 1 / radius, which is convex, from below.
  float lambda = 0.F;
  Eigen::Vector3f u = w;
  for (int k = 0; k < 12; ++k) {
    u = w.array() / (1.F + lambda * variance.array());
    const float norm_sq = u.squaredNorm();
    const float norm = std::sqrt(norm_sq);
    if (norm <= radius * 1.001F) {
      break;
    }
    const float slope = (u.array().square() * variance.array() / (1.F + lambda * variance.array())).sum();
    lambda += norm_sq / slope * (norm - radius) / radius;
  }
  return ((w - u).array().square() / variance.array()).sum();
}

/// Covariance of the apparent velocity of static things, by systematic errors: `radial_mps` along the viewing ray
/// `ray`, whose depth is 1, and `lateral_mps` in all directions.
[[nodiscard]] inline Eigen::Matrix3f apparent_velocity_covariance(const Eigen::Vector3d& ray, double radial_mps,
                                                                  double lateral_mps) {
  // Lower bound of the error of a velocity, whatever its formal precision.
  constexpr double kVelocityFloorMps = 0.03;
  const Eigen::Matrix3d covariance =
      radial_mps * radial_mps * ray * ray.transpose() +
      (lateral_mps * lateral_mps + kVelocityFloorMps * kVelocityFloorMps) * Eigen::Matrix3d::Identity();
  return covariance.cast<float>();
}

/// Covariance of velocities within one object: rotation, and the assumption of constant velocity.
[[nodiscard]] inline Eigen::Matrix3f velocity_slack(const Eigen::Vector3f& velocity_mps) {
  const float sigma_mps = 0.3F + 0.1F * velocity_mps.norm();
  return sigma_mps * sigma_mps * Eigen::Matrix3f::Identity();
}

}  // namespace kinetrace::segmentation
