// What publishing is to a run; a program built without DDS knows this much and no more.
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

/// A run's results on their way out. Calls come from the run's thread and never wait.
class RunPublishing {
 public:
  RunPublishing() = default;
  RunPublishing(const RunPublishing&) = delete;
  RunPublishing& operator=(const RunPublishing&) = delete;
  RunPublishing(RunPublishing&&) = delete;
  RunPublishing& operator=(RunPublishing&&) = delete;
  virtual ~RunPublishing() = default;

  /// `exposed_ns`: steady clock at mid-exposure, 0 where that is not known.
  virtual void offer(const FrameResult& result, std::int64_t exposed_ns) noexcept = 0;
  /// Of a result that comes only with a finalised frame.
  virtual void offer_finalised(const FrameResult& result) noexcept = 0;
  virtual void offer_health(const HealthMonitor& health, const FrameCounters& counters,
                            const RigEstimate& rig) noexcept = 0;
  /// Lets what has been offered go out. Wakes another thread, to which a busy system may give this one's processor: so
  /// this is called when a frame is done. What is offered without it goes out a little later.
  virtual void send() noexcept = 0;
  /// False while what is offered reaches nobody, because network or DDS are not there.
  [[nodiscard]] virtual bool is_connected() const noexcept = 0;
  /// Masks that other processes send go into the mailbox, which outlives this; once, before the first frame.
  virtual void receive_masks(MaskMailbox& mailbox) = 0;
  /// Sends what is left and ends.
  virtual void finish() noexcept = 0;
  /// From exposure until a result was with the network; after finish().
  [[nodiscard]] virtual recording::LatencySummary latency() const = 0;
  /// For run.json.
  [[nodiscard]] virtual std::vector<std::pair<std::string, std::uint64_t>> counters() const = 0;
};

/// What is to be published, checked before any memory is taken.
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
  /// What the DDS library takes by itself.
  [[nodiscard]] virtual std::size_t library_bytes() const = 0;
  /// All settings, for those who write them down.
  [[nodiscard]] virtual ConfigFields fields() = 0;
  /// Starts publishing. Failures: as errors of Publisher::create.
  [[nodiscard]] virtual Outcome<std::unique_ptr<RunPublishing>> start(const StereoGeometry& geometry,
                                                                      Arena& arena) const = 0;
};

/// Reads and checks a file with keys dds.*; paths in it are relative to it. Failures: kNoInput, kIo, kConfig; kUsage
/// where the program has been built without DDS.
[[nodiscard]] Outcome<std::unique_ptr<PublishingSetup>> publishing_setup(const std::string& file, int max_objects);

/// The same for what --publish says: null without it.
[[nodiscard]] inline Outcome<std::unique_ptr<PublishingSetup>> optional_publishing(const std::string& file,
                                                                                   int max_objects) {
  return file.empty() ? nullptr : publishing_setup(file, max_objects);
}

/// With those of publishing behind them, unless it is null.
[[nodiscard]] inline ConfigFields all_fields(ConfigFields fields, PublishingSetup* publishing) {
  if (publishing != nullptr) {
    const ConfigFields more = publishing->fields();
    fields.insert(fields.end(), more.begin(), more.end());
  }
  return fields;
}

}  // namespace kinetrace::app
