// Collects the report of a run for run.json and for the user.
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

/// Message for the user when recording of raw images has stopped.
[[nodiscard]] std::string raw_stopped(const Error& why);

/// Final state of processing.
struct Processed {
  std::int64_t frames = 0;
  int objects_now = 0;
  FrameCounters counters;
  RigEstimate rig;
  AllocationCounts allocations;  ///< Excludes allocations after the last frame.
};

class RunReport {
 public:
  RunReport(const RunOptions& options, const CameraSetup& setup, const pipeline::PipelineConfig& config,
            std::string config_json);

  HealthMonitor health;  ///< Updated with every frame, by all threads.

  /// Planned and allowed memory.
  void set_memory(const RunMemory& plan, const pipeline::MemoryConfig& config);
  /// Geometry of the rectified images.
  void set_geometry(const StereoGeometry& geometry) { geometry_ = geometry; }
  /// Every final estimate, in order.
  void add_finalised(const FrameEstimate& finalised) noexcept { tally_.add(finalised); }
  /// Call before the first frame, after all components exist.
  void start();
  /// Prints a warning at once and keeps it for run.json. Thread-safe.
  void warn_now(const std::string& warning);
  /// Adds a note, printed after the results: information that is no fault.
  void note(std::string note) { notes_.push_back(std::move(note)); }
  /// Call after the last frame. `played`: status of the frames. `capture_clock` timed capture and rectification,
  /// `clock` the rest; they may be the same.
  void finish(const GuardedCamera& camera, const Processed& processed, const StageClock& capture_clock,
              const StageClock& clock, const Status& played);
  /// Adds live mode; after finish().
  void add_live(const recording::LiveSummary& live) { summary_.live = live; }
  /// Adds masks from other processes; after finish().
  void add_masks(const MaskCounters& masks);
  /// Adds the neural network; after finish().
  void add_network(const NetworkThread& network);
  /// Adds the recording of raw images; after finish().
  void add_raw(const RecordingThread& raw);
  /// Adds publishing; after finish() and add_live().
  void add_published(const RunPublishing& published);

  [[nodiscard]] const recording::RunSummary& summary() const noexcept { return summary_; }
  /// Prints a few lines, or run.json with --json. Warnings go to standard error.
  void print() const;
  /// Only the warnings that have not been printed yet.
  void print_warnings() const;

 private:
  [[nodiscard]] bool was_reported(const std::string& warning) const;
  void add_warnings(const GuardedCamera& camera);
  void add_health();

  RunOptions options_;
  bool looks_for_objects_;
  rig::RefineMode calibration_mode_;
  StereoGeometry geometry_;
  RunTally tally_;
  AllocationCounts allocations_at_start_;
  std::chrono::steady_clock::time_point start_;
  double seconds_ = 0.0;
  recording::RunSummary summary_;
  std::unique_ptr<std::mutex> mutex_ =
      std::make_unique<std::mutex>();  ///< Guards the report while frames are processed.
  std::vector<std::string> reported_;  ///< Already printed warnings of summary_.warnings.
  std::vector<std::string> notes_;     ///< For print().
};

}  // namespace kinetrace::app
