// Kinetrace's own topics: writers, and how results become messages.
#pragma once

#include <cstdint>
#include <span>
#include <string>

#include "camera_motion.hpp"
#include "kinetrace.h"
#include "kinetrace/core/arena.hpp"
#include "kinetrace/core/stereo_geometry.hpp"
#include "kinetrace/publishing/published_frame.hpp"
#include "outbox.hpp"

namespace kinetrace::publishing {

/// Buffers that messages are filled in; they outlive participants.
struct NativeBuffers {
  NativeBuffers(const PublishConfig& config, Arena& arena);

  std::span<kinetrace_TrackedObject> objects;
  std::span<float> positions_m;
  std::span<std::uint32_t> track_ids;
  std::span<std::uint8_t> intensities;
};

class NativeTopics {
 public:
  /// Errors: kIo.
  [[nodiscard]] static Result<NativeTopics> create(const PublishConfig& config, dds_entity_t participant);

  void publish(const StereoGeometry& geometry, Outbox& outbox) const;
  void publish(const PublishedFrame& frame, const CameraMotion& motion, const NativeBuffers& buffers,
               Outbox& outbox) const;

 private:
  void publish_camera(const PublishedFrame& frame, const CameraMotion& motion, Outbox& outbox) const;

  std::string device_;
  Writer camera_pose_;
  Writer calibration_;
};

}  // namespace kinetrace::publishing
