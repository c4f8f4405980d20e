// What a run tells about itself: to run.json, and to the user.
#pragma once

#include <chrono>
#include <cstdint>
#include <memory>
#include <mutex>
#include <string>
#include <utility>
#include <vector>

#include "camera/camera_setup.hpp"
#include "camera/health_monitor.hpp"
#include "camera/recording_thread.hpp"
#include "dds/run_publishing.hpp"
#include "kinetrace/core/allocation_counter.hpp"
#include "kinetrace/core/frame_result.hpp"
#include "kinetrace/recording/run_summary.hpp"
#include "live/stage_clock.hpp"
#include "plan/memory.hpp"
#include "run/run_options.hpp"
#include "run/run_tally.hpp"
#include "segmentation/mask_mailbox.hpp"
#include "segmentation/network_thread.hpp"

namespace kinetrace::app {

/// What a user reads when raw images cannot be recorded any longer.
[[nodiscard]] std::string raw_stopped(const Error& why);

/// What processing has come to.
struct Processed {
  std::int64_t frames = 0;
  int objects_now = 0;
  FrameCounters counters;
  RigEstimate rig;
  AllocationCounts allocations;  ///< What comes after the last frame belongs to ending the run.
};

class RunReport {
 public:
  RunReport(const RunOptions& options, const CameraSetup& setup, const pipeline::PipelineConfig& config,
            std::string config_json);

  HealthMonitor health;  ///< Updated with every frame, by all threads.

  /// What is planned, and allowed.
  void set_memory(const RunMemory& plan, const pipeline::MemoryConfig& config);
  /// Of the rectified images.
  void set_geometry(const StereoGeometry& geometry) { geometry_ = geometry; }
  /// Every final estimate, in order.
  void add_finalised(const FrameEstimate& finalised) noexcept { tally_.add(finalised); }
  /// Before the first frame, when everything has been made.
  void start();
  /// Says it at once, and keeps it for run.json. From any thread.
  void warn_now(const std::string& warning);
  /// Says it after the results: what is no fault, and worth knowing.
  void note(std::string note) { notes_.push_back(std::move(note)); }
  /// After the last frame. `played` says how it ended. `capture_clock` timed capture and rectification, `clock` the
  /// rest; they may be the same.
  void finish(const GuardedCamera& camera, const Processed& processed, const StageClock& capture_clock,
              const StageClock& clock, const Status& played);
  /// After finish(), of live mode.
  void add_live(const recording::LiveSummary& live) { summary_.live = live; }
  /// After finish(), where masks came from other processes.
  void add_masks(const MaskCounters& masks);
  /// After finish(), where masks came from a neural network.
  void add_network(const NetworkThread& network);
  /// After finish(), where raw images were recorded.
  void add_raw(const RecordingThread& raw);
  /// After finish() and add_live(), where results were published.
  void add_published(const RunPublishing& published);

  [[nodiscard]] const recording::RunSummary& summary() const noexcept { return summary_; }
  /// For the user: a few lines, or run.json with --json. Warnings go to standard error.
  void print() const;

 private:
  [[nodiscard]] bool was_reported(const std::string& warning) const;
  void add_warnings(const GuardedCamera& camera);
  void add_health();

  RunOptions options_;
  bool looks_for_objects_;
  bool refines_calibration_;
  StereoGeometry geometry_;
  RunTally tally_;
  AllocationCounts allocations_at_start_;
  std::chrono::steady_clock::time_point start_;
  double seconds_ = 0.0;
  recording::RunSummary summary_;
  std::unique_ptr<std::mutex> mutex_ = std::make_unique<std::mutex>();  ///< While frames are processed.
  std::vector<std::string> reported_;  ///< Those of summary_.warnings that the user has read already.
  std::vector<std::string> notes_;     ///< For print().
};

}  // namespace kinetrace::app
