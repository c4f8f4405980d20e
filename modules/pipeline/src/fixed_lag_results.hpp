// The results of the last frames: revised while they are in the window, final when they leave it.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>

#include "camera/camera_tracker.hpp"
#include "kinetrace/core/frame.hpp"
#include "kinetrace/pipeline/config.hpp"
#include "object_state.hpp"
#include "result_ring.hpp"
#include "trajectory_buffer.hpp"

namespace kinetrace::pipeline {

class FixedLagResults {
 public:
  /// Memory: for each frame of the window, its objects and 1.8 kB. The arena may turn out exhausted.
  FixedLagResults(const PipelineConfig& config, Arena& arena);

  /// Adds the newest frame with its objects.
  void push(const RectifiedPair& pair, std::span<const ObjectState> objects);
  /// Updates all frames of the window: poses, smoothed paths, motions. Restarts the objects' motion filters from their
  /// smoothed paths. `vertical`: normal of the ground, world axes, if known.
  void revise(const CameraTracker& camera, const std::optional<Eigen::Vector3d>& vertical,
              std::span<ObjectState> objects);
  /// The object with this track id continues in another slot.
  void move_slot(std::uint32_t track_id, std::uint8_t slot) noexcept { ring_.move_slot(track_id, slot); }

  [[nodiscard]] const BufferedFrame& newest() noexcept { return ring_.frame(0); }
  /// The frame that left the window as the newest one was added: final, returned once. Null if none has.
  [[nodiscard]] const BufferedFrame* finalise() noexcept {
    return pending_ > window_frames_ ? finalise_oldest() : nullptr;
  }
  /// After the last frame: the oldest one not yet published; null once all have been.
  [[nodiscard]] const BufferedFrame* drain() noexcept { return pending_ > 0 ? finalise_oldest() : nullptr; }

 private:
  [[nodiscard]] const BufferedFrame* finalise_oldest() noexcept { return &ring_.frame(--pending_); }
  void revise_poses(const CameraTracker& camera, std::span<ObjectState> objects);
  void smooth_paths(const std::optional<Eigen::Vector3d>& vertical, std::span<ObjectState> objects);
  void describe_motions(std::span<const ObjectState> objects);

  std::size_t window_frames_;
  TrajectoryBuffer paths_;
  ResultRing ring_;
  std::size_t pending_ = 0;  ///< Newest frames of the ring that have not been published as finalised.
};

}  // namespace kinetrace::pipeline
