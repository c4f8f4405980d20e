// Keeps the pipeline within its deadline by adapting its effort.
#pragma once

#include <cstdint>
#include <optional>

#include "kinetrace/core/effort.hpp"
#include "kinetrace/core/health.hpp"

namespace kinetrace::app {

/// Load is shed in a fixed order. Frames are dropped first, by the queue itself: only the newest waits. If deadlines
/// are still missed, levels follow: refinement iterations, points (in two steps), objects (in two steps; unseen and
/// small ones end first, see StereoTracker).
///
/// A late frame adds 1 to a count, a frame in time subtracts 0.5; at `kMaxLateFrames` the next level begins. A fast
/// frame, below `kRecoveryLoad` of the deadline, adds 1 to a second count, any other subtracts `kSlowFrameCost`: at
/// `kRecoveryFrames` one level is taken back, as long as fewer than one frame in eleven is slow. If it is needed again
/// within `kRecoveryFrames`, the count required for the next return doubles, up to 16 times.
class LoadShedder {
 public:
  static constexpr int kLevels = 6;
  static constexpr double kMaxLateFrames = 8.0;
  static constexpr int kRecoveryFrames = 60;
  static constexpr double kRecoveryLoad = 0.6;
  static constexpr int kSlowFrameCost = 10;  ///< In fast frames. Other work on the machine delays single frames.

  LoadShedder(double deadline_ms, int max_objects) noexcept : deadline_ms_(deadline_ms), max_objects_(max_objects) {}

  /// Call after each frame with its processing time. Returns whether `effort()` has changed.
  bool update(double processing_ms) noexcept;

  [[nodiscard]] int level() const noexcept { return level_; }
  [[nodiscard]] Effort effort() const noexcept;
  /// The reason for health at the current level; none at full effort.
  [[nodiscard]] std::optional<HealthReason> health_reason() const noexcept;

 private:
  void set_level(int level) noexcept;

  double deadline_ms_;
  int max_objects_;
  int level_ = 0;
  double late_ = 0.0;
  int fast_frames_ = 0;
  std::optional<int> frames_since_return_;
  int recovery_factor_ = 1;  ///< Multiplier of kRecoveryFrames until the next return.
};

}  // namespace kinetrace::app
