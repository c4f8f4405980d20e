// The table of ROS 2 topics with their names and types.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>

#include "ros2.h"
#include "transport/topic_qos.hpp"

namespace kinetrace::publishing {

enum class RosTopic : std::uint8_t {
  kOdometry,
  kTransforms,
  kStaticTransforms,
  kDetections,
  kMarkers,
  kTrajectories,
  kPoints,
  kDiagnostics,
  kFix,
  kObjectFixes,
};
inline constexpr std::size_t kRosTopicCount = 10;

struct RosTopicKind {
  std::string_view name;
  const dds_topic_descriptor_t* type = nullptr;
  TopicQos qos;
  bool is_common = false;  ///< Shared by the ROS system: without Kinetrace's prefix.

  /// Name in ROS.
  [[nodiscard]] std::string ros_name(const std::string& prefix) const {
    return (is_common || prefix.empty() ? "/" : "/" + prefix + "/") + std::string(name);
  }
  /// Name on the wire.
  [[nodiscard]] std::string dds_name(const std::string& prefix) const { return "rt" + ros_name(prefix); }
};

[[nodiscard]] inline const RosTopicKind& kind_of(RosTopic topic) {
  constexpr TopicQos kNewest{.encoding = Encoding::kRos, .depth = 1};
  constexpr TopicQos kSome{.encoding = Encoding::kRos, .depth = 8};
  constexpr TopicQos kAll{.encoding = Encoding::kRos, .depth = 64};
  constexpr TopicQos kKept{.encoding = Encoding::kRos, .depth = 1, .keeps_last = true};
  static const std::array<RosTopicKind, kRosTopicCount> kKinds{
      {{"odometry", &nav_msgs_msg_dds__Odometry__desc, kNewest},
       {"tf", &tf2_msgs_msg_dds__TFMessage__desc, kSome, true},
       {"tf_static", &tf2_msgs_msg_dds__TFMessage__desc, kKept, true},
       {"detections", &vision_msgs_msg_dds__Detection3DArray__desc, kSome},
       {"markers", &visualization_msgs_msg_dds__MarkerArray__desc, kSome},
       {"trajectories", &geometry_msgs_msg_dds__PoseArray__desc, kAll},
       {"points", &sensor_msgs_msg_dds__PointCloud2__desc, kNewest},
       {"diagnostics", &diagnostic_msgs_msg_dds__DiagnosticArray__desc, kSome, true},
       {"fix", &sensor_msgs_msg_dds__NavSatFix__desc, kNewest},
       {"object_fixes", &sensor_msgs_msg_dds__NavSatFix__desc, kAll}}};
  return kKinds[static_cast<std::size_t>(topic)];
}

}  // namespace kinetrace::publishing
