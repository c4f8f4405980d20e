// Expected messages of the scene, topic by topic.
#pragma once

#include <string>
#include <vector>

#include "fast_dds.hpp"

namespace kinetrace::test {

/// One line for each wrong field; none if all are right.
using Mistakes = std::vector<std::string>;

[[nodiscard]] Mistakes mistakes_in(const nav_msgs::msg::Odometry& message);
[[nodiscard]] Mistakes mistakes_in(const vision_msgs::msg::Detection3DArray& message);
[[nodiscard]] Mistakes mistakes_in(const visualization_msgs::msg::MarkerArray& message);
[[nodiscard]] Mistakes mistakes_in(const geometry_msgs::msg::PoseArray& message);
[[nodiscard]] Mistakes mistakes_in(const sensor_msgs::msg::PointCloud2& message);
[[nodiscard]] Mistakes mistakes_in(const diagnostic_msgs::msg::DiagnosticArray& message);
[[nodiscard]] Mistakes mistakes_in_tf(const tf2_msgs::msg::TFMessage& message);
[[nodiscard]] Mistakes mistakes_in_static_tf(const tf2_msgs::msg::TFMessage& message);

}  // namespace kinetrace::test
