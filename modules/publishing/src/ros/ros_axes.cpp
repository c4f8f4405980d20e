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
  // Rotation comes from below, position from above; both turn into the axes of ROS.
  Matrix6d J = Matrix6d::Zero();
  J.topRightCorner<3, 3>() = ros_axes();
  J.bottomLeftCorner<3, 3>() = ros_axes();
  return J * covariance * J.transpose();
}

RosBox to_ros(const Box3& box) noexcept {
  // At yaw 0 the length lies along our +x, which is -y of ROS; our yaw turns about down, theirs about up.
  const double yaw_rad = -box.yaw_rad - std::numbers::pi / 2.0;
  return {{Eigen::AngleAxisd(yaw_rad, Eigen::Vector3d::UnitZ()).toRotationMatrix(), ros_axes() * box.center_m},
          {box.size_m.x(), box.size_m.z(), box.size_m.y()}};
}

}  // namespace kinetrace::publishing
