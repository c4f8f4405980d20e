// Keeps a pipeline within its deadline by letting it do less, and more again.
#pragma once

#include <cstdint>
#include <optional>

#include "kinetrace/core/effort.hpp"
#include "kinetrace/core/health.hpp"

namespace kinetrace::app {

/// What is shed goes in a declared order. Whole frames come first, and by themselves: while one is processed, only the
/// newest waits. When that goes on, level after level: refinement iterations, points (in two steps), objects (in two
/// steps; what is unseen and small ends first, see StereoTracker).
///
/// A late frame counts one, a frame in time takes half of one back; at `kMaxLateFrames` the next level begins. After
/// `kEasyFrames` in a row that needed less than `kEasyPart` of the deadline one level is taken back. Where that proves
/// wrong within as many frames, the next return takes twice as long, up to 16 times.
class LoadShedder {
 public:
  static constexpr int kLevels = 6;
  static constexpr double kMaxLateFrames = 8.0;
  static constexpr int kEasyFrames = 60;
  static constexpr double kEasyPart = 0.6;

  LoadShedder(double deadline_ms, int max_objects) noexcept : deadline_ms_(deadline_ms), max_objects_(max_objects) {}

  /// After each frame, with what it took to process. Returns whether `effort()` has changed.
  bool update(double processing_ms) noexcept;

  [[nodiscard]] int level() const noexcept { return level_; }
  [[nodiscard]] Effort effort() const noexcept;
  /// What is shed now, for health; none at full effort.
  [[nodiscard]] std::optional<HealthReason> sheds() const noexcept;

 private:
  void set_level(int level) noexcept;

  double deadline_ms_;
  int max_objects_;
  int level_ = 0;
  double late_ = 0.0;
  int easy_frames_ = 0;
  std::optional<int> frames_since_return_;
  int caution_ = 1;  ///< Times kEasyFrames until the next return.
};

}  // namespace kinetrace::app
