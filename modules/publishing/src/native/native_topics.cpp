#include "native/native_topics.hpp"

#include <algorithm>
#include <array>

#include "kinetrace/publishing/topics.hpp"
#include "native/native_values.hpp"
#include "transport/sequences.hpp"

namespace kinetrace::publishing {
namespace {

// Bounds in the IDL.
constexpr std::size_t kMaxObjectsInPiece = 64;
constexpr std::size_t kMaxPointsInPiece = 1024;
constexpr std::size_t kMaxReasons = 32;
constexpr std::size_t kMaxCounters = 64;
static_assert(kHealthReasonCount <= kMaxReasons);
static_assert(kFrameCounterNames.size() + kPublishCounterNames.size() <= kMaxCounters);

// Three coordinates, an id, an intensity.
constexpr std::size_t kPointBytes = 3 * sizeof(float) + sizeof(std::uint32_t) + sizeof(std::uint8_t);

kinetrace_TrackedObject tracked_object(const ObjectResult& object) noexcept {
  kinetrace_TrackedObject out{};
  out.id = object.track_id;
  out.class_id = object.class_id;
  out.status = to_wire(object.status);
  out.moving = object.moving;
  out.T_world_obj = to_wire(object.T_world_obj);
  copy_upper_triangle(object.covariance, out.covariance);
  copy_floats(object.velocity_mps, out.velocity_mps);
  out.heading_rad = static_cast<float>(object.heading_rad);
  out.box_center_m = to_wire(object.box.center_m);
  copy_floats(object.box.size_m, out.box_size_m);
  out.box_yaw_rad = static_cast<float>(object.box.yaw_rad);
  out.box_px[0] = object.box_px.x0;
  out.box_px[1] = object.box_px.y0;
  out.box_px[2] = object.box_px.x1;
  out.box_px[3] = object.box_px.y1;
  out.points = static_cast<std::uint32_t>(object.point_count);
  out.inliers = static_cast<std::uint32_t>(object.inliers);
  copy_floats(object.box.down, out.box_down);
  copy_floats(object.box_sigma.center_m, out.box_center_sigma_m);
  copy_floats(object.box_sigma.size_m, out.box_size_sigma_m);
  out.box_yaw_sigma_rad = static_cast<float>(object.box_sigma.yaw_rad);
  out.heading_known = object.box_sigma.heading_known;
  return out;
}

kinetrace_CalibrationEstimate calibration_estimate(const RigEstimate& rig, const StereoGeometry& geometry) {
  kinetrace_CalibrationEstimate out{};
  out.verdict = to_wire(rig.verdict);
  Eigen::Map<RigCorrection::Vector>(out.estimate) = rig.correction.vector();
  Eigen::Map<RigCorrection::Vector>(out.sigma) = rig.sigma_rad;
  Eigen::Map<RigCorrection::Vector>(out.applied) = rig.applied.vector();
  out.disparity_error_px = rig.correction.disparity_error_rad() * geometry.fx_px;
  out.disparity_sigma_px = rig.disparity_sigma_rad * geometry.fx_px;
  for (std::size_t i = 0; i < kReportedDepths_m.size(); ++i) {
    out.depth_m[i] = kReportedDepths_m.at(i);
    out.depth_error_m[i] = depth_error_m(geometry, rig.correction, kReportedDepths_m.at(i));
  }
  out.windows = rig.windows;
  out.knocks = rig.knocks;
  return out;
}

}  // namespace

NativeBuffers::NativeBuffers(const PublishConfig& config, Arena& arena) {
  const std::size_t object_count =
      items_per_piece(config.piece_bytes, sizeof(kinetrace_TrackedObject), kMaxObjectsInPiece);
  const std::size_t point_count = items_per_piece(config.piece_bytes, kPointBytes, kMaxPointsInPiece);
  objects = arena.take<kinetrace_TrackedObject>(object_count);
  positions_m = arena.take<float>(3 * point_count);
  track_ids = arena.take<std::uint32_t>(point_count);
  intensities = arena.take<std::uint8_t>(point_count);
  reasons = arena.take<kinetrace_HealthReason>(kHealthReasonCount);
  counters = arena.take<kinetrace_Counter>(kFrameCounterNames.size() + kPublishCounterNames.size());
}

Result<NativeTopics> NativeTopics::create(const PublishConfig& config, const StereoGeometry& geometry,
                                          const NativeBuffers& buffers, dds_entity_t participant) {
  NativeTopics made(config, geometry, buffers);
  const TopicQos newest{.depth = 1};
  const TopicQos pieces{.depth = 8};
  const TopicQos all{.depth = 64};
  const TopicQos kept{.depth = 1, .keeps_last = true};
  const std::array<TopicSpec, 6> specs{
      {{made.camera_pose_, kinetrace_CameraPose_desc, topics::kCameraPose, newest, Priority::kEssential},
       {made.objects_, kinetrace_TrackedObjects_desc, topics::kObjects, pieces, Priority::kEssential},
       {made.trajectories_, kinetrace_TrajectoryPiece_desc, topics::kTrajectories, all, Priority::kTrajectories},
       {made.points_, kinetrace_PointPiece_desc, topics::kPoints, pieces, Priority::kPoints},
       {made.health_, kinetrace_Health_desc, topics::kHealth, kept, Priority::kEssential},
       {made.calibration_, kinetrace_Calibration_desc, topics::kCalibration, kept, Priority::kEssential}}};
  if (const Status writers = make_writers(participant, specs); !writers) {
    return Unexpected(writers.error());
  }
  return made;
}

void NativeTopics::publish(const StereoGeometry& geometry, Outbox& outbox) const {
  kinetrace_Calibration message{};
  copy_text(device_, message.device);
  message.width_px = static_cast<std::uint32_t>(geometry.width_px);
  message.height_px = static_cast<std::uint32_t>(geometry.height_px);
  message.fx_px = geometry.fx_px;
  message.fy_px = geometry.fy_px;
  message.cx_px = geometry.cx_px;
  message.cy_px = geometry.cy_px;
  message.baseline_m = geometry.baseline_m;
  outbox.write(calibration_, &message, sizeof(message));
}

void NativeTopics::publish(const PublishedFrame& frame, const CameraMotion& motion, Outbox& outbox) const {
  publish_camera(frame, motion, outbox);
  publish_objects(frame, outbox);
}

void NativeTopics::publish_camera(const PublishedFrame& frame, const CameraMotion& motion, Outbox& outbox) const {
  if (!Outbox::is_wanted(camera_pose_)) {
    return;
  }
  kinetrace_CameraPose message{};
  copy_text(device_, message.device);
  message.frame = frame.frame_index;
  message.timestamp_ns = frame.timestamp_ns;
  message.handed_over_ns = frame.handed_over_ns;
  message.status = to_wire(frame.camera.status);
  message.T_world_cam = to_wire(frame.camera.T_world_cam);
  Eigen::Map<Matrix6d>(static_cast<double*>(message.covariance)) = frame.camera.covariance;  // Symmetric.
  message.velocity_mps = to_wire(motion.velocity_mps);
  message.angular_velocity_radps = to_wire(motion.angular_velocity_radps);
  outbox.write(camera_pose_, &message, sizeof(message));
}

void NativeTopics::publish_objects(const PublishedFrame& frame, Outbox& outbox) const {
  if (!Outbox::is_wanted(objects_)) {
    return;
  }
  kinetrace_TrackedObjects message{};
  copy_text(device_, message.device);
  message.frame = frame.frame_index;
  message.timestamp_ns = frame.timestamp_ns;
  message.handed_over_ns = frame.handed_over_ns;
  message.total = static_cast<std::uint32_t>(frame.objects.size());
  in_pieces(frame.objects.size(), buffers_.objects.size(), [&](const Piece& piece) {
    const std::span<kinetrace_TrackedObject> objects = buffers_.objects.first(piece.count);
    for (std::size_t i = 0; i < piece.count; ++i) {
      objects[i] = tracked_object(frame.objects[piece.first + i]);
    }
    message.piece = piece.index;
    message.pieces = piece.of;
    set_items(message.objects, objects);
    outbox.write(objects_, &message, sizeof(message) + objects.size_bytes());
  });
}

void NativeTopics::publish_points(const PublishedFrame& frame, Outbox& outbox) const {
  if (frame.points.capacity() == 0 || !Outbox::is_wanted(points_)) {
    return;
  }
  kinetrace_PointPiece message{};
  copy_text(device_, message.device);
  message.frame = frame.frame_index;
  message.timestamp_ns = frame.timestamp_ns;
  message.total = static_cast<std::uint32_t>(frame.points.size());
  message.available = static_cast<std::uint32_t>(frame.points_available);
  in_pieces(frame.points.size(), buffers_.track_ids.size(), [&](const Piece& piece) {
    for (std::size_t i = 0; i < piece.count; ++i) {
      const PublishedPoint& point = frame.points[piece.first + i];
      Eigen::Map<Eigen::Vector3f>(&buffers_.positions_m[3 * i]) = point.position_m;
      buffers_.track_ids[i] = point.track_id;
      buffers_.intensities[i] = point.intensity;
    }
    message.piece = piece.index;
    message.pieces = piece.of;
    set_items(message.position_m, buffers_.positions_m.first(3 * piece.count));
    set_items(message.track_id, buffers_.track_ids.first(piece.count));
    set_items(message.intensity, buffers_.intensities.first(piece.count));
    outbox.write(points_, &message, sizeof(message) + piece.count * kPointBytes);
  });
}

void NativeTopics::publish(const PublishedHealth& health, const PublishCounters& sent, Outbox& outbox) const {
  kinetrace_Health message{};
  copy_text(device_, message.device);
  message.frame = health.frame_index;
  message.handed_over_ns = health.handed_over_ns;
  message.state = to_wire(health.state);
  copy_text(health.camera, message.camera);
  std::size_t reasons = 0;
  for (const HealthEntry& entry : health.entries) {
    if (entry.count > 0) {
      kinetrace_HealthReason& out = buffers_.reasons[reasons++];
      copy_text(to_string(entry.reason), out.name);
      out.count = entry.count;
      out.first_frame = entry.first_frame;
      out.last_frame = entry.last_frame;
    }
  }
  std::size_t counters = 0;
  const auto add_counter = [&](std::string_view name, std::uint64_t value) {
    kinetrace_Counter& out = buffers_.counters[counters++];
    copy_text(name, out.name);
    out.value = value;
  };
  for (const auto& [name, member] : kFrameCounterNames) {
    add_counter(name, health.counters.*member);
  }
  for (const auto& [name, member] : kPublishCounterNames) {
    add_counter(name, sent.*member);
  }
  message.calibration = calibration_estimate(health.rig, geometry_);
  set_items(message.reasons, buffers_.reasons.first(reasons));
  set_items(message.counters, buffers_.counters.first(counters));
  outbox.write(health_, &message,
               sizeof(message) + reasons * sizeof(kinetrace_HealthReason) + counters * sizeof(kinetrace_Counter));
}

void NativeTopics::publish(const TrajectoryPart& part, Outbox& outbox) const {
  if (!Outbox::is_wanted(trajectories_)) {
    return;
  }
  kinetrace_TrajectoryPiece message{};
  copy_text(device_, message.device);
  message.id = part.track_id;
  message.class_id = part.class_id;
  message.finished = part.finished;
  message.first_pose = part.first_pose;
  set_items(message.poses, part.poses);
  outbox.write(trajectories_, &message, sizeof(message) + part.poses.size_bytes());
}

}  // namespace kinetrace::publishing
