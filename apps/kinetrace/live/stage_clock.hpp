// Times the stages of a frame.
#pragma once

#include <algorithm>
#include <array>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include "kinetrace/core/allocation_counter.hpp"
#include "kinetrace/core/stage.hpp"
#include "kinetrace/recording/latency_histogram.hpp"

namespace kinetrace::app {

/// A stage's time is that between its enter and leave, without nested stages; a stage entered several times in a frame
/// counts once, with the sum. The frame's time is that between begin_frame and end_frame, without kCapture (decoding of
/// images and masks). Libraries' allocations in the clock's thread are counted in the same way. `Clock` has a static
/// now(), as in <chrono>.
template <typename Clock>
class BasicStageClock final : public StageObserver {
 public:
  void enter(Stage stage) noexcept override {
    credit();
    if (depth_ < open_.size()) {
      open_[depth_] = stage;
    }
    ++depth_;
  }
  void leave(Stage /*stage*/) noexcept override {
    credit();
    --depth_;
  }

  void begin_frame() noexcept {
    credit();
    capture_before_ns_ = elapsed_ns_[index(Stage::kCapture)];
    frame_start_ = last_;
  }
  void end_frame() noexcept {
    credit();
    const std::int64_t capture_ns = elapsed_ns_[index(Stage::kCapture)] - capture_before_ns_;
    frames_.add(nanoseconds(last_ - frame_start_) - capture_ns);
    for (std::size_t i = 0; i < kStageCount; ++i) {
      stages_[i].add(elapsed_ns_[i]);
      most_foreign_[i] = std::max(most_foreign_[i], foreign_[i]);
    }
    elapsed_ns_.fill(0);
    foreign_.fill(0);
  }

  [[nodiscard]] recording::TimingSummary frame_time() const noexcept { return frames_.summary(); }
  [[nodiscard]] std::vector<std::pair<std::string, recording::TimingSummary>> stage_times() const {
    std::vector<std::pair<std::string, recording::TimingSummary>> times;
    for (std::size_t i = 0; i < kStageCount; ++i) {
      times.emplace_back(to_string(static_cast<Stage>(i)), stages_[i].summary());
    }
    return times;
  }
  /// Maximum of the libraries' allocations in a frame, by stage.
  [[nodiscard]] std::vector<std::pair<std::string, std::uint64_t>> foreign_allocations() const {
    std::vector<std::pair<std::string, std::uint64_t>> counts;
    for (std::size_t i = 0; i < kStageCount; ++i) {
      counts.emplace_back(to_string(static_cast<Stage>(i)), most_foreign_[i]);
    }
    return counts;
  }

 private:
  static constexpr std::size_t kMaxDepth = 4;  ///< Deeper stages are credited to the fourth.
  static std::size_t index(Stage stage) noexcept { return static_cast<std::size_t>(stage); }
  static std::int64_t nanoseconds(typename Clock::duration duration) noexcept {
    return std::chrono::duration_cast<std::chrono::nanoseconds>(duration).count();
  }
  // Gives the time since the last event to the innermost open stage.
  void credit() noexcept {
    const typename Clock::time_point now = Clock::now();
    const std::uint64_t foreign = thread_allocation_counts().foreign;
    if (depth_ > 0) {
      const Stage innermost = open_[std::min(depth_, open_.size()) - 1];
      elapsed_ns_[index(innermost)] += nanoseconds(now - last_);
      foreign_[index(innermost)] += foreign - last_foreign_;
    }
    last_ = now;
    last_foreign_ = foreign;
  }

  std::array<Stage, kMaxDepth> open_{};
  std::size_t depth_ = 0;
  typename Clock::time_point last_{};
  typename Clock::time_point frame_start_{};
  std::int64_t capture_before_ns_ = 0;
  std::array<std::int64_t, kStageCount> elapsed_ns_{};
  std::array<recording::LatencyHistogram, kStageCount> stages_;
  std::uint64_t last_foreign_ = 0;
  std::array<std::uint64_t, kStageCount> foreign_{};
  std::array<std::uint64_t, kStageCount> most_foreign_{};
  recording::LatencyHistogram frames_;
};

using StageClock = BasicStageClock<std::chrono::steady_clock>;

}  // namespace kinetrace::app
