#include "ros/ros_axes.hpp"

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
  // Rotation comes from below, position from above; both turn into the axes of ROS.
  Matrix6d J = Matrix6d::Zero();
  J.topRightCorner<3, 3>() = ros_axes();
  J.bottomLeftCorner<3, 3>() = ros_axes();
  return J * covariance * J.transpose();
}

RosBox to_ros(const Box3& box) noexcept {
  // Length, left and up; ours are length, down and left.
  const Eigen::Matrix3d axes = box.rotation();
  Eigen::Matrix3d R_world_box;
  R_world_box << axes.col(0), axes.col(2), -axes.col(1);
  return {{ros_axes() * R_world_box, ros_axes() * box.center_m}, {box.size_m.x(), box.size_m.z(), box.size_m.y()}};
}

}  // namespace kinetrace::publishing
