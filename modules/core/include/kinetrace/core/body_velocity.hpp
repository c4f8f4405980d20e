// Velocity of a body between two poses, in its own axes, and its derivatives by the poses.
#pragma once

#include "kinetrace/core/se3.hpp"

namespace kinetrace {

/// Standard deviations of the apparent velocity and turn rate of an object at rest, in addition to its covariance.
inline constexpr double kRestSpeedSigma_mps = 0.05;
inline constexpr double kRestTurnSigma_radps = 0.01;

/// Velocity (rad/s, m/s) and its derivatives by perturbations (rotation about the world's axes, position) of both
/// poses.
struct BodyVelocity {
  Vector6d value;
  Matrix6d by_from;
  Matrix6d by_to;
};

/// From T_world_body at one time to that `interval_s` > 0 later. The rotation between them is assumed small: the
/// derivative of the logarithm is taken at zero.
[[nodiscard]] inline BodyVelocity body_velocity(const Se3& from, const Se3& to, double interval_s) {
  const double rate = 1.0 / interval_s;
  const Eigen::Vector3d way = to.translation - from.translation;
  const Eigen::Matrix3d to_body = from.rotation.transpose();
  BodyVelocity v;
  v.value << rate * so3_log(to_body * to.rotation), rate * (to_body * way);
  v.by_to = Matrix6d::Zero();
  v.by_to.topLeftCorner<3, 3>() = rate * to.rotation.transpose();
  v.by_to.bottomRightCorner<3, 3>() = rate * to_body;
  v.by_from = -v.by_to;
  v.by_from.bottomLeftCorner<3, 3>() = rate * to_body * skew(way);
  return v;
}

}  // namespace kinetrace
