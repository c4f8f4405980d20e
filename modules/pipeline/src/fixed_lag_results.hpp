// The results of the last frames: revised while they are in the window, final when they leave it.
#pragma once

#include <cstddef>
#include <cstdint>
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

  /// The newest frame, with the objects as they are known in it.
  void push(const RectifiedPair& pair, std::span<const ObjectState> objects);
  /// Updates all frames of the window to what it knows by now: poses, smoothed paths, motions. Objects learn from their
  /// smoothed paths how they move.
  void revise(const CameraTracker& camera, std::span<ObjectState> objects);
  /// The object with this track id goes on in another slot.
  void move_slot(std::uint32_t track_id, std::uint8_t slot) noexcept { ring_.move_slot(track_id, slot); }

  [[nodiscard]] const BufferedFrame& newest() noexcept { return ring_.frame(0); }
  /// The frame that has left the window with the newest one: final, and published once. Null while none has.
  [[nodiscard]] const BufferedFrame* finalise() noexcept {
    return pending_ > window_frames_ ? finalise_oldest() : nullptr;
  }
  /// The oldest frame of the window, where no more frames come; null once all have been published.
  [[nodiscard]] const BufferedFrame* drain() noexcept { return pending_ > 0 ? finalise_oldest() : nullptr; }

 private:
  [[nodiscard]] const BufferedFrame* finalise_oldest() noexcept { return &ring_.frame(--pending_); }
  void revise_poses(const CameraTracker& camera, std::span<ObjectState> objects);
  void smooth_paths(std::span<ObjectState> objects);
  void describe_motions(std::span<const ObjectState> objects);

  std::size_t window_frames_;
  TrajectoryBuffer paths_;
  ResultRing ring_;
  std::size_t pending_ = 0;  ///< Newest frames of the ring that have not been published as finalised.
};

}  // namespace kinetrace::pipeline
