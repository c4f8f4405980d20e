// Native topics: writers, and conversion of results to messages.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>

#include "kinetrace.h"
#include "kinetrace/core/arena.hpp"
#include "kinetrace/core/stereo_geometry.hpp"
#include "kinetrace/publishing/published_frame.hpp"
#include "native/trajectory_pieces.hpp"
#include "results/camera_motion.hpp"
#include "transport/outbox.hpp"

namespace kinetrace::publishing {

/// Message buffers; outlive participants.
struct NativeBuffers {
  NativeBuffers(const PublishConfig& config, Arena& arena);

  std::span<kinetrace_TrackedObject> objects;  ///< Capacity of a piece; points likewise.
  std::span<float> positions_m;
  std::span<std::uint32_t> track_ids;
  std::span<std::uint8_t> intensities;
  std::span<kinetrace_HealthReason> reasons;
  std::span<kinetrace_Counter> counters;
};

class NativeTopics {
 public:
  /// Errors: kIo.
  [[nodiscard]] static Result<NativeTopics> create(const PublishConfig& config, const StereoGeometry& geometry,
                                                   const NativeBuffers& buffers, dds_entity_t participant);

  void publish(const StereoGeometry& geometry, Outbox& outbox) const;
  /// Pose and objects.
  void publish(const PublishedFrame& frame, const CameraMotion& motion, Outbox& outbox) const;
  /// The topics of lower priority.
  void publish_points(const PublishedFrame& frame, Outbox& outbox) const;
  void publish(const PublishedHealth& health, const PublishCounters& sent, Outbox& outbox) const;
  void publish(const TrajectoryPart& part, Outbox& outbox) const;

 private:
  NativeTopics(const PublishConfig& config, const StereoGeometry& geometry, const NativeBuffers& buffers)
      : device_(config.device), geometry_(geometry), buffers_(buffers) {}
  void publish_camera(const PublishedFrame& frame, const CameraMotion& motion, Outbox& outbox) const;
  void publish_objects(const PublishedFrame& frame, Outbox& outbox) const;

  std::string device_;
  StereoGeometry geometry_;
  NativeBuffers buffers_;
  Writer camera_pose_;
  Writer objects_;
  Writer trajectories_;
  Writer points_;
  Writer health_;
  Writer calibration_;
};

}  // namespace kinetrace::publishing
