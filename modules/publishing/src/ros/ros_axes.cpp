#include "ros/ros_axes.hpp"

#include <numbers>

namespace kinetrace::publishing {

const Eigen::Matrix3d& ros_axes() noexcept {
  static const Eigen::Matrix3d R_ros_ours =
      (Eigen::Matrix3d() << 0.0, 0.0, 1.0, -1.0, 0.0, 0.0, 0.0, -1.0, 0.0).finished();
  return R_ros_ours;
}

Se3 to_ros(const Se3& T_a_b) noexcept {
  const Eigen::Matrix3d& R = ros_axes();
  return {R * T_a_b.rotation * R.transpose(), R * T_a_b.translation};
}

Matrix6d to_ros_covariance(const Matrix6d& covariance) noexcept {
  // Swaps the blocks of rotation and position, and rotates both into the axes of ROS.
  Matrix6d J = Matrix6d::Zero();
  J.topRightCorner<3, 3>() = ros_axes();
  J.bottomLeftCorner<3, 3>() = ros_axes();
  return J * covariance * J.transpose();
}

RosBox to_ros(const Box3& box) noexcept {
  // From (length, down, left) to (length, left, up).
  const Eigen::Matrix3d axes = box.rotation();
  Eigen::Matrix3d R_world_box;
  R_world_box << axes.col(0), axes.col(2), -axes.col(1);
  return {{ros_axes() * R_world_box, ros_axes() * box.center_m}, {box.size_m.x(), box.size_m.z(), box.size_m.y()}};
}

Matrix6d to_ros_covariance(const RosBox& box, const Box3Sigma& sigma) noexcept {
  constexpr double kTilt_rad = 0.03;  // Typical slope of the ground and lean of vehicles.
  const double half_turns_rad2 = sigma.heading_known ? 0.0 : 0.5 * std::numbers::pi * std::numbers::pi;
  const Eigen::Vector3d position_m(sigma.center_m.x(), sigma.center_m.z(), sigma.center_m.y());
  const Eigen::Vector3d rotation_rad2(kTilt_rad * kTilt_rad, kTilt_rad * kTilt_rad,
                                      sigma.yaw_rad * sigma.yaw_rad + half_turns_rad2);
  const Eigen::Matrix3d& axes = box.T_odom_box.rotation;
  Matrix6d covariance = Matrix6d::Zero();
  covariance.topLeftCorner<3, 3>() = axes * position_m.cwiseAbs2().asDiagonal() * axes.transpose();
  covariance.bottomRightCorner<3, 3>() = axes * rotation_rad2.asDiagonal() * axes.transpose();
  return covariance;
}

}  // namespace kinetrace::publishing
