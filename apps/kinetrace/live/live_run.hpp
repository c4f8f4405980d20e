// Live mode: processing beside capture, the newest frame first, within a deadline.
#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>

#include "camera/health_monitor.hpp"
#include "config/live_config.hpp"
#include "kinetrace/core/arena.hpp"
#include "kinetrace/core/effort.hpp"
#include "kinetrace/core/frame.hpp"
#include "kinetrace/core/result.hpp"
#include "kinetrace/recording/run_summary.hpp"
#include "live/load_shedder.hpp"
#include "live/pipeline_thread.hpp"

namespace kinetrace::app {

/// Plays a recording at its recorded pace, or a multiple.
class Pacer {
 public:
  explicit Pacer(double speed) noexcept : speed_(speed) {}
  /// Waits until a frame with this time stamp is due, or a signal arrives. Returns the due time on the steady clock; a
  /// frame that arrives late is due at its arrival and delays all later ones.
  std::int64_t wait_for(std::int64_t timestamp_ns);

 private:
  double speed_;
  std::optional<std::int64_t> first_timestamp_ns_;
  std::int64_t first_due_ns_ = 0;
};

/// Owns the processing thread. While a pair is processed, the newest other pair waits; the pair that it replaces is
/// dropped and counted. Order and results of processed pairs are the same as without this class.
class LiveRun {
 public:
  struct Processing {
    PipelineThread::Process process;
    std::function<void()> idle;                ///< Called periodically while no frame arrives.
    std::function<void(const Effort&)> limit;  ///< Called between two calls of `process`.
    int max_objects = 0;                       ///< Configured value.
  };

  [[nodiscard]] static std::size_t required_bytes(const StereoGeometry& geometry) {
    return PipelineThread::required_bytes(geometry);
  }
  /// `is_paced`: frames are read without delay and paced by their time stamps; else time stamps are of the steady
  /// clock. All calls of `processing` come from one thread; `health` must outlive this. Errors: those of
  /// PipelineThread::create.
  [[nodiscard]] static Result<std::unique_ptr<LiveRun>> create(const LiveConfig& config, double nominal_rate_hz,
                                                               bool is_paced, const StereoGeometry& geometry,
                                                               Processing processing, HealthMonitor& health,
                                                               Arena& arena);

  /// Call before processing a frame: waits until it is due if frames are paced.
  void await(const StereoFrame& frame);
  /// Errors: those of `process`, of an earlier pair.
  [[nodiscard]] Status offer(const RectifiedPair& pair);
  /// Processes the waiting pair. Errors: those of `process`.
  [[nodiscard]] Status finish() noexcept { return thread_->finish(); }

  /// After finish().
  [[nodiscard]] recording::LiveSummary summary() const noexcept;

 private:
  LiveRun(const LiveConfig& config, double nominal_rate_hz, bool is_paced, Processing processing,
          HealthMonitor& health);
  Status process(const RectifiedPair& pair, std::int64_t exposed_ns);
  void adapt(std::chrono::steady_clock::duration took);

  Processing processing_;
  HealthMonitor& health_;
  std::optional<Pacer> pacer_;
  std::int64_t due_ns_ = 0;
  std::uint64_t left_out_ = 0;
  bool reduces_effort_;
  double deadline_ms_;
  // Of the processing thread.
  LoadShedder shedder_;
  recording::LatencyHistogram latency_;
  std::uint64_t late_ = 0;
  int worst_level_ = 0;
  std::unique_ptr<PipelineThread> thread_;  ///< Last, so that it ends first.
};

}  // namespace kinetrace::app
