// Interface of publishing for a run, without dependencies on DDS.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "camera/health_monitor.hpp"
#include "cli/failure.hpp"
#include "config/config_fields.hpp"
#include "kinetrace/core/arena.hpp"
#include "kinetrace/core/frame_result.hpp"
#include "kinetrace/core/memory_plan.hpp"
#include "kinetrace/core/stereo_geometry.hpp"
#include "kinetrace/recording/latency_histogram.hpp"
#include "segmentation/mask_mailbox.hpp"

namespace kinetrace::app {

/// Publishes a run's results. Called from the run's thread; never blocks.
class RunPublishing {
 public:
  RunPublishing() = default;
  RunPublishing(const RunPublishing&) = delete;
  RunPublishing& operator=(const RunPublishing&) = delete;
  RunPublishing(RunPublishing&&) = delete;
  RunPublishing& operator=(RunPublishing&&) = delete;
  virtual ~RunPublishing() = default;

  /// `exposed_ns`: steady clock at mid-exposure; 0: unknown.
  virtual void offer(const FrameResult& result, std::int64_t exposed_ns) noexcept = 0;
  /// For a result with a finalised frame only.
  virtual void offer_finalised(const FrameResult& result) noexcept = 0;
  virtual void offer_health(const HealthMonitor& health, const FrameCounters& counters,
                            const RigEstimate& rig) noexcept = 0;
  /// Sends what was offered. Wakes another thread, which may take this thread's processor on a busy system: call it at
  /// the end of a frame. Without this call, results are sent a little later.
  virtual void send() noexcept = 0;
  /// False while nothing can be sent for lack of a network or of DDS.
  [[nodiscard]] virtual bool is_connected() const noexcept = 0;
  /// Starts to receive masks from other processes into the mailbox, which must outlive this; once, before the first
  /// frame.
  virtual void receive_masks(MaskMailbox& mailbox) = 0;
  /// Sends the remainder and ends.
  virtual void finish() noexcept = 0;
  /// Latency from exposure until a result was sent; after finish().
  [[nodiscard]] virtual recording::LatencySummary latency() const = 0;
  /// For run.json.
  [[nodiscard]] virtual std::vector<std::pair<std::string, std::uint64_t>> counters() const = 0;
};

/// Checked configuration of publishing, created before memory is allocated.
class PublishingSetup {
 public:
  PublishingSetup() = default;
  PublishingSetup(const PublishingSetup&) = delete;
  PublishingSetup& operator=(const PublishingSetup&) = delete;
  PublishingSetup(PublishingSetup&&) = delete;
  PublishingSetup& operator=(PublishingSetup&&) = delete;
  virtual ~PublishingSetup() = default;

  /// From the arena.
  [[nodiscard]] virtual MemoryPlanEntry plan() const = 0;
  /// Memory of the DDS library itself.
  [[nodiscard]] virtual std::size_t library_bytes() const = 0;
  /// All settings, for run.json.
  [[nodiscard]] virtual ConfigFields fields() = 0;
  /// Starts publishing. Failures: as errors of Publisher::create.
  [[nodiscard]] virtual Outcome<std::unique_ptr<RunPublishing>> start(const StereoGeometry& geometry,
                                                                      Arena& arena) const = 0;
};

/// Reads and checks a file with keys dds.*; paths in it are relative to it. Failures: kNoInput, kIo, kConfig; kUsage in
/// a program built without DDS.
[[nodiscard]] Outcome<std::unique_ptr<PublishingSetup>> publishing_setup(const std::string& file, int max_objects);

/// The same for the value of --publish: null if it is empty.
[[nodiscard]] inline Outcome<std::unique_ptr<PublishingSetup>> optional_publishing(const std::string& file,
                                                                                   int max_objects) {
  return file.empty() ? nullptr : publishing_setup(file, max_objects);
}

/// The configuration's fields, followed by those of publishing unless it is null.
[[nodiscard]] inline ConfigFields all_fields(ConfigFields fields, PublishingSetup* publishing) {
  if (publishing != nullptr) {
    const ConfigFields more = publishing->fields();
    fields.insert(fields.end(), more.begin(), more.end());
  }
  return fields;
}

}  // namespace kinetrace::app
