// What messages of ROS 2 consist of, in ROS's own words: for files that explain themselves.
#pragma once

#include <string>
#include <string_view>

#include "kinetrace/core/export.hpp"

namespace kinetrace::publishing {

/// The .msg text of a type such as "nav_msgs/msg/Odometry", followed by those of all types in it, as MCAP files of ROS
/// 2 hold them (encoding "ros2msg"). Empty for types that we do not publish.
[[nodiscard]] KINETRACE_API std::string ros_definition(std::string_view type);

}  // namespace kinetrace::publishing
