// The results of the last frames: revised while they are in the window, final when they leave it.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "camera_tracker.hpp"
#include "kept_paths.hpp"
#include "kinetrace/core/frame.hpp"
#include "kinetrace/pipeline/config.hpp"
#include "object_state.hpp"
#include "result_ring.hpp"

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

  [[nodiscard]] const KeptFrame& newest() noexcept { return ring_.frame(0); }
  /// The frame that has left the window with the newest one: final, and given out once. Null while none has.
  [[nodiscard]] const KeptFrame* settle() noexcept { return unsettled_ > window_frames_ ? settle_oldest() : nullptr; }
  /// The oldest frame of the window, where no more frames come; null once all have been given out.
  [[nodiscard]] const KeptFrame* drain() noexcept { return unsettled_ > 0 ? settle_oldest() : nullptr; }

 private:
  [[nodiscard]] const KeptFrame* settle_oldest() noexcept { return &ring_.frame(--unsettled_); }
  void revise_poses(const CameraTracker& camera, std::span<ObjectState> objects);
  void smooth_paths(std::span<ObjectState> objects);
  void describe_motions(std::span<const ObjectState> objects);

  std::size_t window_frames_;
  KeptPaths paths_;
  ResultRing ring_;
  std::size_t unsettled_ = 0;  ///< Newest frames of the ring that have not been given out as settled.
};

}  // namespace kinetrace::pipeline
