#include "ros/ros_topics.hpp"

#include <algorithm>
#include <bit>
#include <cstdio>
#include <cstring>

#include "results/thinning.hpp"
#include "ros/ros_axes.hpp"
#include "ros/ros_topic_table.hpp"
#include "ros/ros_values.hpp"
#include "transport/sequences.hpp"

namespace kinetrace::publishing {
namespace {

constexpr std::size_t kDetectionBytes =
    sizeof(vision_msgs_msg_dds__Detection3D_) + sizeof(vision_msgs_msg_dds__ObjectHypothesisWithPose_) + 64;
constexpr std::size_t kMarkerBytes =
    sizeof(visualization_msgs_msg_dds__Marker_) + 2 * sizeof(geometry_msgs_msg_dds__Point_);
// x, y, z and the track, four bytes each.
constexpr std::size_t kPointBytes = 16;
constexpr std::size_t kHeaderBytes = 64;

// ROS cannot represent a lost pose, so it is not published.
bool has_place(BodyStatus status) noexcept {
  return status != BodyStatus::kLost && status != BodyStatus::kInitializing;
}

// ROS requires a score.
double score(BodyStatus status) noexcept {
  return status == BodyStatus::kTracked ? 1.0 : status == BodyStatus::kStereoOnly ? 0.5 : 0.25;
}

// ROS cannot represent an unknown covariance either; filters treat this one as unknown.
Matrix6d unknown_covariance() noexcept {
  constexpr double kHuge = 1e6;
  return kHuge * Matrix6d::Identity();
}

Se3 pose_of(const kinetrace_TrajectoryPose& pose) noexcept {
  const Eigen::Quaterniond q = Eigen::Map<const Eigen::Quaternionf>(pose.orientation_xyzw).cast<double>();
  return {q.toRotationMatrix(), {pose.position.x, pose.position.y, pose.position.z}};
}

void fill(const ObjectResult& object, const std_msgs_msg_dds__Header_& header, RosBuffers::DetectionStorage& storage,
          vision_msgs_msg_dds__Detection3D_& detection) noexcept {
  copy_text(ClassName(object.class_id).view(), storage.class_name);
  std::snprintf(storage.id.data(), storage.id.size(), "%u", object.track_id);
  storage.hypothesis.hypothesis = {storage.class_name.data(), score(object.status)};
  const RosBox box = to_ros(object.box);
  storage.hypothesis.pose.pose = ros_pose(box.T_odom_box);
  copy_covariance(to_ros_covariance(box, object.box_sigma), storage.hypothesis.pose.covariance);
  detection = {};
  detection.header = header;
  set_items(detection.results, {&storage.hypothesis, 1});
  detection.bbox = {ros_pose(box.T_odom_box), ros_vector(box.size_m)};
  detection.id = storage.id.data();
}

/// Calls `add(object)` for the published objects.
template <typename Add>
void for_each_placed(const PublishedFrame& frame, Add&& add) {
  for (const ObjectResult& object : frame.objects) {
    if (has_place(object.status)) {
      add(object);
    }
  }
}

}  // namespace

RosBuffers::RosBuffers(const PublishConfig& config, Arena& arena)
    : marked_objects(items_per_piece(config.piece_bytes, RosMarkers::kPerObject * kMarkerBytes, kMaxObjects)),
      markers(arena, marked_objects),
      diagnostics(arena) {
  const std::size_t detected = items_per_piece(config.piece_bytes, kDetectionBytes, kMaxObjects);
  detections = arena.take<vision_msgs_msg_dds__Detection3D_>(detected);
  detection_storage = arena.take<DetectionStorage>(detected);
  poses = arena.take<geometry_msgs_msg_dds__Pose_>(TrajectoryPieces::kMaxPoses);
  const auto most_points = static_cast<std::size_t>(config.max_points);
  const std::size_t points =
      std::min(most_points, items_per_piece(config.piece_bytes, kPointBytes, PublishConfig::kMaxPoints));
  cloud = arena.take<std::uint8_t>(points * kPointBytes);
}

void RosStamper::observe(const PublishedFrame& frame) noexcept {
  ahead_ns_ = stamps_ == RosStamps::kSystem ? frame.handed_over_ns - frame.timestamp_ns : 0;
}

std_msgs_msg_dds__Header_ RosStamper::header(std::int64_t timestamp_ns, const std::string& frame) const noexcept {
  return {ros_time(timestamp_ns + ahead_ns_), ros_text(frame)};
}

Result<RosTopics> RosTopics::create(const PublishConfig& config, RosBuffers& buffers, dds_entity_t participant) {
  RosTopics made(config, buffers);
  struct Topic {
    Writer& writer;
    RosTopic topic;
    Priority priority;
  };
  const std::array<Topic, 8> topics{{{made.odometry_, RosTopic::kOdometry, Priority::kEssential},
                                     {made.transforms_, RosTopic::kTransforms, Priority::kEssential},
                                     {made.static_transforms_, RosTopic::kStaticTransforms, Priority::kEssential},
                                     {made.detections_, RosTopic::kDetections, Priority::kEssential},
                                     {made.markers_, RosTopic::kMarkers, Priority::kDrawings},
                                     {made.trajectories_, RosTopic::kTrajectories, Priority::kTrajectories},
                                     {made.points_, RosTopic::kPoints, Priority::kPoints},
                                     {made.diagnostics_, RosTopic::kDiagnostics, Priority::kEssential}}};
  for (const Topic& topic : topics) {
    const RosTopicKind& kind = kind_of(topic.topic);
    Result<Writer> writer =
        Writer::create(participant, *kind.type, kind.dds_name(config.ros2.prefix), kind.qos, topic.priority);
    if (!writer) {
      return Unexpected(writer.error());
    }
    topic.writer = std::move(*writer);
  }
  return made;
}

void RosTopics::publish(const StereoGeometry& geometry, Outbox& outbox) const {
  const RosConfig& ros = config_->ros2;
  const Se3 T_base_left{ros_axes(), Eigen::Vector3d::Zero()};
  const Se3 T_left_right{Eigen::Matrix3d::Identity(), {geometry.baseline_m, 0.0, 0.0}};
  std::array<geometry_msgs_msg_dds__TransformStamped_, 2> transforms{
      {{{ros_time(0), ros_text(ros.base_frame)}, ros_text(ros.left_frame), ros_transform(T_base_left)},
       {{ros_time(0), ros_text(ros.left_frame)}, ros_text(ros.right_frame), ros_transform(T_left_right)}}};
  tf2_msgs_msg_dds__TFMessage_ message{};
  set_items(message.transforms, transforms);
  outbox.write(static_transforms_, &message, sizeof(transforms));
}

void RosTopics::publish(const PublishedFrame& frame, const CameraMotion& motion, Outbox& outbox) {
  stamper_.observe(frame);
  if (has_place(frame.camera.status)) {
    publish_odometry(frame, motion, outbox);
    publish_transform(frame, outbox);
  }
  publish_detections(frame, outbox);
}

void RosTopics::publish_drawings(const PublishedFrame& frame, Outbox& outbox) const {
  publish_markers(frame, outbox);
  publish_cloud(frame, outbox);
}

void RosTopics::publish_odometry(const PublishedFrame& frame, const CameraMotion& motion, Outbox& outbox) const {
  if (!Outbox::is_wanted(odometry_)) {
    return;
  }
  nav_msgs_msg_dds__Odometry_ message{};
  message.header = stamper_.header(frame.timestamp_ns, config_->ros2.odom_frame);
  message.child_frame_id = ros_text(config_->ros2.base_frame);
  message.pose.pose = ros_pose(to_ros(frame.camera.T_world_cam));
  copy_covariance(to_ros_covariance(frame.camera.covariance), message.pose.covariance);
  message.twist.twist = {ros_vector(ros_axes() * motion.velocity_mps),
                         ros_vector(ros_axes() * motion.angular_velocity_radps)};
  copy_covariance(motion.is_known ? to_ros_covariance(motion.covariance) : unknown_covariance(),
                  message.twist.covariance);
  outbox.write(odometry_, &message, sizeof(message) + kHeaderBytes);
}

void RosTopics::publish_transform(const PublishedFrame& frame, Outbox& outbox) const {
  if (!Outbox::is_wanted(transforms_)) {
    return;
  }
  geometry_msgs_msg_dds__TransformStamped_ transform{stamper_.header(frame.timestamp_ns, config_->ros2.odom_frame),
                                                     ros_text(config_->ros2.base_frame),
                                                     ros_transform(to_ros(frame.camera.T_world_cam))};
  tf2_msgs_msg_dds__TFMessage_ message{};
  set_items(message.transforms, {&transform, 1});
  outbox.write(transforms_, &message, sizeof(transform) + kHeaderBytes);
}

void RosTopics::publish_detections(const PublishedFrame& frame, Outbox& outbox) const {
  if (!Outbox::is_wanted(detections_)) {
    return;
  }
  const std_msgs_msg_dds__Header_ header = stamper_.header(frame.timestamp_ns, config_->ros2.odom_frame);
  std::size_t count = 0;
  bool is_sent = false;
  const auto send = [&] {
    vision_msgs_msg_dds__Detection3DArray_ message{};
    message.header = header;
    set_items(message.detections, buffers_->detections.first(count));
    outbox.write(detections_, &message, kHeaderBytes + count * kDetectionBytes);
    count = 0;
    is_sent = true;
  };
  for_each_placed(frame, [&](const ObjectResult& object) {
    if (count == buffers_->detections.size()) {
      send();
    }
    fill(object, header, buffers_->detection_storage[count], buffers_->detections[count]);
    ++count;
  });
  if (count > 0 || !is_sent) {
    send();  // An empty message is sent, too.
  }
}

void RosTopics::publish_markers(const PublishedFrame& frame, Outbox& outbox) const {
  if (!Outbox::is_wanted(markers_)) {
    return;
  }
  const std_msgs_msg_dds__Header_ header = stamper_.header(frame.timestamp_ns, config_->ros2.odom_frame);
  RosMarkers& markers = buffers_->markers;
  std::size_t count = 0;
  const auto send = [&] {
    visualization_msgs_msg_dds__MarkerArray_ message{};
    set_items(message.markers, markers.markers());
    outbox.write(markers_, &message, kHeaderBytes + markers.markers().size() * kMarkerBytes);
    markers.clear();
    count = 0;
  };
  markers.clear();
  for_each_placed(frame, [&](const ObjectResult& object) {
    if (count == buffers_->marked_objects) {
      send();
    }
    markers.add(object, header);
    ++count;
  });
  if (count > 0) {
    send();
  }
}

void RosTopics::publish_cloud(const PublishedFrame& frame, Outbox& outbox) const {
  if (buffers_->cloud.empty() || !Outbox::is_wanted(points_)) {
    return;
  }
  constexpr std::uint8_t kUint32 = 6;  // sensor_msgs/PointField.
  constexpr std::uint8_t kFloat32 = 7;
  std::array<sensor_msgs_msg_dds__PointField_, 4> fields{{{ros_text("x"), 0, kFloat32, 1},
                                                          {ros_text("y"), 4, kFloat32, 1},
                                                          {ros_text("z"), 8, kFloat32, 1},
                                                          {ros_text("track_id"), 12, kUint32, 1}}};
  const Eigen::Matrix3f axes = ros_axes().cast<float>();
  Thinning thinning(buffers_->cloud.size() / kPointBytes, frame.points.size());
  std::uint8_t* out = buffers_->cloud.data();
  for (const PublishedPoint& point : frame.points) {
    if (thinning.lets_through()) {
      const Eigen::Vector3f position_m = axes * point.position_m;
      std::memcpy(out, position_m.data(), 3 * sizeof(float));
      std::memcpy(out + 3 * sizeof(float), &point.track_id, sizeof(std::uint32_t));
      out += kPointBytes;
    }
  }
  sensor_msgs_msg_dds__PointCloud2_ message{};
  message.header = stamper_.header(frame.timestamp_ns, config_->ros2.odom_frame);
  message.height = 1;
  message.width = static_cast<std::uint32_t>(thinning.kept());
  set_items(message.fields, fields);
  message.is_bigendian = std::endian::native == std::endian::big;
  message.point_step = kPointBytes;
  message.row_step = message.width * message.point_step;
  set_items(message.data, buffers_->cloud.first(message.row_step));
  message.is_dense = true;
  outbox.write(points_, &message, kHeaderBytes + sizeof(fields) + message.row_step);
}

void RosTopics::publish(const PublishedHealth& health, const PublishCounters& sent, Outbox& outbox) const {
  if (!Outbox::is_wanted(diagnostics_)) {
    return;
  }
  const std_msgs_msg_dds__Header_ header{ros_time(health.handed_over_ns), ros_text("")};
  const diagnostic_msgs_msg_dds__DiagnosticArray_ message =
      buffers_->diagnostics.fill(health, sent, config_->device, header);
  constexpr std::size_t kValueBytes = 48;
  outbox.write(diagnostics_, &message, kHeaderBytes + message.status._buffer->values._length * kValueBytes);
}

void RosTopics::publish(const TrajectoryPart& part, Outbox& outbox) const {
  if (part.poses.empty() || !Outbox::is_wanted(trajectories_)) {
    return;
  }
  const std::span<geometry_msgs_msg_dds__Pose_> poses = buffers_->poses.first(part.poses.size());
  for (std::size_t i = 0; i < poses.size(); ++i) {
    poses[i] = ros_pose(to_ros(pose_of(part.poses[i])));
  }
  geometry_msgs_msg_dds__PoseArray_ message{};
  message.header = stamper_.header(part.poses.back().timestamp_ns, config_->ros2.odom_frame);
  set_items(message.poses, poses);
  outbox.write(trajectories_, &message, kHeaderBytes + poses.size_bytes());
}

}  // namespace kinetrace::publishing
