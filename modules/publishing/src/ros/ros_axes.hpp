// Converts Kinetrace's axes (x right, y down, z forward) to those of ROS (REP 103: x forward, y left, z up).
#pragma once

#include <Eigen/Core>

#include "kinetrace/core/frame_result.hpp"
#include "kinetrace/core/se3.hpp"

namespace kinetrace::publishing {

/// R_ros_ours: p_ros = R_ros_ours * p_ours.
[[nodiscard]] const Eigen::Matrix3d& ros_axes() noexcept;

/// Rotates both frames of T_a_b to the axes of ROS.
[[nodiscard]] Se3 to_ros(const Se3& T_a_b) noexcept;

/// Of (position, rotation), as ROS orders it, from one of (rotation, position).
[[nodiscard]] Matrix6d to_ros_covariance(const Matrix6d& covariance) noexcept;

/// An upright box: x is its length, y its width, z its height.
struct RosBox {
  Se3 T_odom_box;  ///< Its origin is the box's centre.
  Eigen::Vector3d size_m;
};
[[nodiscard]] RosBox to_ros(const Box3& box) noexcept;
/// Covariance of that pose, (position, rotation) about the axes of odom. A yaw with unknown heading includes the
/// variance of half turns.
[[nodiscard]] Matrix6d to_ros_covariance(const RosBox& box, const Box3Sigma& sigma) noexcept;

}  // namespace kinetrace::publishing
