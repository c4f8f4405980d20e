#include "ros/ros_markers.hpp"

#include <cstdio>

#include "kinetrace/core/class_name.hpp"
#include "ros/ros_axes.hpp"
#include "ros/ros_values.hpp"
#include "transport/sequences.hpp"

namespace kinetrace::publishing {
namespace {

// visualization_msgs/Marker.
constexpr int kArrow = 0;
constexpr int kCube = 1;
constexpr int kText = 9;

constexpr double kShaftDiameter_m = 0.1;
constexpr double kHeadDiameter_m = 0.25;
constexpr double kTextHeight_m = 0.4;

// Okabe and Ito's colours, which colour-blind readers tell apart too.
constexpr std::array<std_msgs_msg_dds__ColorRGBA_, 6> kColours{{{0.90F, 0.62F, 0.00F, 0.6F},
                                                                {0.34F, 0.71F, 0.91F, 0.6F},
                                                                {0.00F, 0.62F, 0.45F, 0.6F},
                                                                {0.94F, 0.89F, 0.26F, 0.6F},
                                                                {0.00F, 0.45F, 0.70F, 0.6F},
                                                                {0.84F, 0.37F, 0.00F, 0.6F}}};
constexpr std_msgs_msg_dds__ColorRGBA_ kWhite{1.0F, 1.0F, 1.0F, 1.0F};

visualization_msgs_msg_dds__Marker_ empty_marker(const std_msgs_msg_dds__Header_& header) noexcept {
  visualization_msgs_msg_dds__Marker_ marker{};
  char* const nothing = ros_text("");
  marker.header = header;
  marker.pose.orientation.w = 1.0;
  marker.texture_resource = nothing;
  marker.texture.header.frame_id = nothing;
  marker.texture.format = nothing;
  marker.text = nothing;
  marker.mesh_resource = nothing;
  marker.mesh_file.filename = nothing;
  marker.lifetime.sec = RosMarkers::kLifetime_s;
  return marker;
}

}  // namespace

RosMarkers::RosMarkers(Arena& arena, std::size_t max_objects)
    : markers_(arena.take<visualization_msgs_msg_dds__Marker_>(kPerObject * max_objects)),
      storage_(arena.take<Storage>(kPerObject * max_objects)) {}

visualization_msgs_msg_dds__Marker_& RosMarkers::next(const ObjectResult& object,
                                                      const std_msgs_msg_dds__Header_& header, const char* ns,
                                                      int type) noexcept {
  visualization_msgs_msg_dds__Marker_& marker = markers_[count_++];
  marker = empty_marker(header);
  marker.ns = ros_text(ns);
  marker.id = static_cast<std::int32_t>(object.track_id);
  marker.type = type;
  marker.color = kColours[object.track_id % kColours.size()];
  return marker;
}

void RosMarkers::add(const ObjectResult& object, const std_msgs_msg_dds__Header_& header) noexcept {
  const RosBox box = to_ros(object.box);
  visualization_msgs_msg_dds__Marker_& cube = next(object, header, "box", kCube);
  cube.pose = ros_pose(box.T_odom_box);
  cube.scale = ros_vector(box.size_m);

  Storage& label = storage_[count_];
  std::snprintf(label.label.data(), label.label.size(), "%s %u", ClassName(object.class_id).c_str(), object.track_id);
  visualization_msgs_msg_dds__Marker_& text = next(object, header, "name", kText);
  text.text = label.label.data();
  text.color = kWhite;
  text.scale.z = kTextHeight_m;
  text.pose.position =
      ros_point(box.T_odom_box.translation + Eigen::Vector3d(0.0, 0.0, box.size_m.z() / 2.0 + kTextHeight_m));

  if (object.moving) {
    Storage& arrow = storage_[count_];
    const Eigen::Vector3d ahead_m = ros_axes() * object.velocity_mps;  // One second.
    arrow.arrow = {ros_point(box.T_odom_box.translation), ros_point(box.T_odom_box.translation + ahead_m)};
    visualization_msgs_msg_dds__Marker_& velocity = next(object, header, "velocity", kArrow);
    velocity.scale = {kShaftDiameter_m, kHeadDiameter_m, 0.0};
    set_items(velocity.points, arrow.arrow);
  }
}

}  // namespace kinetrace::publishing
