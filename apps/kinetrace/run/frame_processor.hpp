// Processes a camera's frames; records and publishes the results.
#pragma once

#include <atomic>
#include <memory>
#include <mutex>

#include "kinetrace/core/allocation_counter.hpp"
#include "live/live_run.hpp"
#include "live/stage_clock.hpp"
#include "run/run_components.hpp"
#include "run/run_report.hpp"

namespace kinetrace::app {

/// State shared by the processing thread and the capture thread.
class Progressed {
 public:
  void set(const Processed& value) {
    const std::lock_guard lock(mutex_);
    value_ = value;
  }
  [[nodiscard]] Processed get() const {
    const std::lock_guard lock(mutex_);
    return value_;
  }

 private:
  mutable std::mutex mutex_;
  Processed value_;
};

/// Processes a run's frames in the calling thread, or in a thread of its own (live). Called from the capture thread;
/// `components` and `report` must outlive it.
class FrameProcessor {
 public:
  FrameProcessor(RunComponents& components, RunReport& report) : components_(components), report_(report) {}

  /// Switches to live mode; once, before the first frame. Errors: those of LiveRun::create.
  [[nodiscard]] Status go_live(const RunSetup& setup, double rate_hz, Arena& arena);
  /// Errors: those of the components; in live mode, those of an earlier frame.
  [[nodiscard]] Status process(const StereoFrame& frame);
  /// Call while no frame arrives. In live mode the processing thread reports health.
  void on_idle();
  /// Call after the last frame. Errors: those of the waiting frames; kBadFormat if no mask file was usable.
  [[nodiscard]] Status finish();

  [[nodiscard]] Processed processed() const;
  [[nodiscard]] StageClock& capture_clock() noexcept { return capture_clock_ ? *capture_clock_ : *clock_; }
  [[nodiscard]] const StageClock& clock() const noexcept { return *clock_; }
  /// Null if not live.
  [[nodiscard]] const LiveRun* live() const noexcept { return live_.get(); }

 private:
  [[nodiscard]] Result<RectifiedPair> prepare(const StereoFrame& frame);
  void record_raw(const StereoFrame& frame);
  /// `exposed_ns`: steady clock at mid-exposure; 0: unknown.
  [[nodiscard]] Status process_pair(const RectifiedPair& pair, std::int64_t exposed_ns);
  void offer_result(const FrameResult& result, std::int64_t exposed_ns);
  [[nodiscard]] Status note_masks(const FrameResult& result);
  void publish_health();

  RunComponents& components_;
  RunReport& report_;
  Warn warn_ = [this](const std::string& warning) { report_.warn_now(warning); };
  Progressed progressed_;
  std::atomic<bool> calibration_corrected_ = false;  ///< Written by the processing thread.
  std::unique_ptr<StageClock> clock_ = std::make_unique<StageClock>();
  AllocationCounts allocations_at_last_offer_;
  std::uint64_t mask_frames_missing_ = 0;      ///< So far.
  std::unique_ptr<StageClock> capture_clock_;  ///< Null: the same.
  std::unique_ptr<LiveRun> live_;              ///< Last, so that its thread ends first.
};

}  // namespace kinetrace::app
