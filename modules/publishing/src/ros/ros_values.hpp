// Conversion of single values to ROS 2 messages.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "kinetrace/core/se3.hpp"
#include "ros2.h"

namespace kinetrace::publishing {

/// The C structures of messages need non-const pointers; writing does not modify the text.
[[nodiscard]] inline char* ros_text(const char* text) noexcept {
  return const_cast<char*>(text);  // NOLINT(cppcoreguidelines-pro-type-const-cast)
}
[[nodiscard]] inline char* ros_text(const std::string& text) noexcept {
  return ros_text(text.c_str());
}

[[nodiscard]] inline geometry_msgs_msg_dds__Point_ ros_point(const Eigen::Vector3d& p) noexcept {
  return {p.x(), p.y(), p.z()};
}
[[nodiscard]] inline geometry_msgs_msg_dds__Vector3_ ros_vector(const Eigen::Vector3d& v) noexcept {
  return {v.x(), v.y(), v.z()};
}
[[nodiscard]] inline geometry_msgs_msg_dds__Quaternion_ ros_quaternion(const Eigen::Quaterniond& q) noexcept {
  return {q.x(), q.y(), q.z(), q.w()};
}
[[nodiscard]] inline geometry_msgs_msg_dds__Pose_ ros_pose(const Se3& pose) noexcept {
  return {ros_point(pose.translation), ros_quaternion(pose.quaternion())};
}
[[nodiscard]] inline geometry_msgs_msg_dds__Transform_ ros_transform(const Se3& pose) noexcept {
  return {ros_vector(pose.translation), ros_quaternion(pose.quaternion())};
}

/// Times before 1970, as in a recording without dates, become 0.
[[nodiscard]] constexpr builtin_interfaces_msg_dds__Time_ ros_time(std::int64_t time_ns) noexcept {
  constexpr std::int64_t kSecond_ns = 1'000'000'000;
  const std::int64_t clamped_ns = time_ns < 0 ? 0 : time_ns;
  return {static_cast<std::int32_t>(clamped_ns / kSecond_ns), static_cast<std::uint32_t>(clamped_ns % kSecond_ns)};
}

inline void copy_covariance(const Matrix6d& from, double (&to)[36]) noexcept {
  Eigen::Map<Matrix6d>(static_cast<double*>(to)) = from;  // Symmetric, so the order of storage does not matter.
}

}  // namespace kinetrace::publishing
