// ROS 2 message definitions, for self-describing files.
#pragma once

#include <string>
#include <string_view>

#include "kinetrace/core/export.hpp"

namespace kinetrace::publishing {

/// The .msg text of a type such as "nav_msgs/msg/Odometry", followed by those of all types in it, as MCAP files of ROS
/// 2 hold them (encoding "ros2msg"). Empty for types that Kinetrace does not publish.
[[nodiscard]] KINETRACE_API std::string ros_definition(std::string_view type);

}  // namespace kinetrace::publishing
