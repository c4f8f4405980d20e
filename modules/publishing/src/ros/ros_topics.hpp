// Topics for ROS 2: writers, and conversion of results to messages.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "kinetrace/core/arena.hpp"
#include "kinetrace/core/class_name.hpp"
#include "kinetrace/core/stereo_geometry.hpp"
#include "kinetrace/publishing/published_frame.hpp"
#include "native/trajectory_pieces.hpp"
#include "results/camera_motion.hpp"
#include "ros/ros_diagnostics.hpp"
#include "ros/ros_markers.hpp"
#include "ros2.h"
#include "transport/outbox.hpp"

namespace kinetrace::publishing {

/// Message buffers; outlive participants.
struct RosBuffers {
  RosBuffers(const PublishConfig& config, Arena& arena);

  /// Storage that a detection points to.
  struct DetectionStorage {
    vision_msgs_msg_dds__ObjectHypothesisWithPose_ hypothesis;
    std::array<char, 16> class_name;
    std::array<char, 12> id;
  };
  std::span<vision_msgs_msg_dds__Detection3D_> detections;  ///< As many as go into a message.
  std::span<DetectionStorage> detection_storage;
  std::size_t marked_objects;  ///< As many as go into a message.
  RosMarkers markers;
  std::span<geometry_msgs_msg_dds__Pose_> poses;
  std::span<std::uint8_t> cloud;
  RosDiagnostics diagnostics;
};

/// Frames and clock of headers.
class RosStamper {
 public:
  explicit RosStamper(const RosConfig& config) noexcept : stamps_(config.stamps) {}
  /// Updates the offset of the system clock from the source's.
  void observe(const PublishedFrame& frame) noexcept;
  [[nodiscard]] std_msgs_msg_dds__Header_ header(std::int64_t timestamp_ns, const std::string& frame) const noexcept;

 private:
  RosStamps stamps_;
  std::int64_t ahead_ns_ = 0;
};

class RosTopics {
 public:
  /// `config` and `buffers` must outlive it. Errors: kIo.
  [[nodiscard]] static Result<RosTopics> create(const PublishConfig& config, RosBuffers& buffers,
                                                dds_entity_t participant);

  void publish(const StereoGeometry& geometry, Outbox& outbox) const;
  /// Pose and objects.
  void publish(const PublishedFrame& frame, const CameraMotion& motion, Outbox& outbox);
  /// The topics of lower priority: markers and points.
  void publish_drawings(const PublishedFrame& frame, Outbox& outbox) const;
  void publish(const PublishedHealth& health, const PublishCounters& sent, Outbox& outbox) const;
  void publish(const TrajectoryPart& part, Outbox& outbox) const;

 private:
  RosTopics(const PublishConfig& config, RosBuffers& buffers)
      : config_(&config), buffers_(&buffers), stamper_(config.ros2) {}
  void publish_odometry(const PublishedFrame& frame, const CameraMotion& motion, Outbox& outbox) const;
  void publish_transform(const PublishedFrame& frame, Outbox& outbox) const;
  void publish_detections(const PublishedFrame& frame, Outbox& outbox) const;
  void publish_markers(const PublishedFrame& frame, Outbox& outbox) const;
  void publish_cloud(const PublishedFrame& frame, Outbox& outbox) const;

  const PublishConfig* config_;
  RosBuffers* buffers_;
  RosStamper stamper_;
  Writer odometry_;
  Writer transforms_;
  Writer static_transforms_;
  Writer detections_;
  Writer markers_;
  Writer trajectories_;
  Writer points_;
  Writer diagnostics_;
};

}  // namespace kinetrace::publishing
