// Weighted least squares of a path: position and velocity at time zero.
#pragma once

#include <span>

#include <Eigen/Core>

namespace kinetrace::trajectory {

/// Prior standard deviation of velocities along the ground: wide, so that it matters only where errors of depth explain
/// any velocity.
inline constexpr double kSpeedPriorSigma_mps = 50.0;

struct PathPoint {
  double time_s = 0.0;  ///< Relative to the time of interest.
  Eigen::Vector3d position_m = Eigen::Vector3d::Zero();
  Eigen::Matrix3d information = Eigen::Matrix3d::Identity();  ///< Inverse covariance of the position.
};

struct VelocityFit {
  Eigen::Vector3d velocity_mps = Eigen::Vector3d::Zero();
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();
};

/// Fits constant velocity or, where significant and with at least kMinAcceleratedPoints points, constant acceleration.
/// Covariances are scaled up where the residuals exceed the given information. Needs at least two points; the prior of
/// the velocity keeps the fit finite for points of equal time.
inline constexpr std::size_t kMinAcceleratedPoints = 7;
[[nodiscard]] VelocityFit fit_velocity(std::span<const PathPoint> points, const Eigen::Matrix3d& prior_information);

}  // namespace kinetrace::trajectory
