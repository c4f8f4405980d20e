#include <algorithm>
#include <chrono>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <utility>

#include "app_config.hpp"
#include "camera_loop.hpp"
#include "camera_setup.hpp"
#include "clocks.hpp"
#include "commands.hpp"
#include "config_file.hpp"
#include "interrupt.hpp"
#include "kinetrace/core/allocation_counter.hpp"
#include "kinetrace/core/config_check.hpp"
#include "kinetrace/hal/rectifier.hpp"
#include "kinetrace/hal/sync_monitor.hpp"
#include "kinetrace/pipeline/pipeline.hpp"
#include "kinetrace/recording/run_recorder.hpp"
#include "live_run.hpp"
#include "mask_mailbox.hpp"
#include "memory.hpp"
#include "messages.hpp"
#include "pairing_keeper.hpp"
#include "progress.hpp"
#include "recording_thread.hpp"
#include "run_publishing.hpp"
#include "run_report.hpp"
#include "service_notifier.hpp"
#include "stage_clock.hpp"

namespace kinetrace::app {
namespace {

// The parts of a run, in the order that a frame passes them. All memory is taken when they are made.
struct Chain {
  GuardedCamera camera;
  hal::Rectifier rectifier;
  std::unique_ptr<MaskMailbox> masks;  // Null unless masks come from another process.
  pipeline::Pipeline pipeline;
  recording::RunRecorder recorder;
  std::optional<PairingKeeper> pairing;          // Of cameras; a recording is as it is.
  std::unique_ptr<RecordingThread> raw;          // Null unless asked for.
  std::unique_ptr<RecordingThread> raw_ended{};  // What became of it where it stopped early.
  bool waits_for_disk = false;                   // Recordings do; a camera would lose frames meanwhile.
  std::unique_ptr<RunPublishing> publishing{};   // Null unless asked for.
  std::unique_ptr<ServiceNotifier> service = std::make_unique<ServiceNotifier>();
};

// What is there only where it is asked for.
Outcome<void> add_extras(Chain& chain, const CameraSetup& setup, const RunOptions& options, Arena& arena) {
  if (setup.is_camera) {
    const StereoGeometry& geometry = chain.rectifier.geometry();
    auto monitor = hal::SyncMonitor::create({}, geometry.width_px, geometry.height_px, arena);
    if (!monitor) {
      return failure(monitor.error());
    }
    chain.pairing.emplace(*monitor, chain.camera.live);
  }
  if (!options.raw.out.empty()) {
    const double rate_hz = setup.live ? setup.live->left.rate_hz : setup.dataset->nominal_rate_hz;
    auto raw = RecordingThread::create(raw_recorder_config(options.raw, setup.calibration, rate_hz), arena);
    if (!raw) {
      return tl::unexpected(raw.error());
    }
    chain.raw = std::move(*raw);
    chain.waits_for_disk = !setup.live;
  }
  if (chain.masks) {
    chain.publishing->receive_masks(*chain.masks);
  }
  return {};
}

Outcome<Chain> make_chain(const AppConfig& config, const CameraSetup& setup, const PublishingSetup* publishing,
                          const RunOptions& options, Arena& arena) {
  auto camera = setup.make(arena);
  if (!camera) {
    return failure(camera.error());
  }
  auto rectifier = hal::Rectifier::create(setup.calibration, config.rectification, arena);
  if (!rectifier) {
    return failure(rectifier.error());
  }
  std::unique_ptr<MaskMailbox> masks;
  if (const std::optional<MaskMailboxConfig> wanted = mask_mailbox_config(config, rectifier->geometry())) {
    masks = std::make_unique<MaskMailbox>(*wanted, arena);
  }
  auto pipeline = pipeline::Pipeline::create(config.pipeline, rectifier->geometry(), arena, masks.get());
  if (!pipeline) {
    return failure(pipeline.error());
  }
  std::unique_ptr<RunPublishing> published;
  if (publishing != nullptr) {
    auto started = publishing->start(rectifier->geometry(), arena);
    if (!started) {
      return tl::unexpected(started.error());
    }
    published = std::move(*started);
  }
  // Last, so that nothing is made or replaced in the run folder unless everything else is ready.
  auto recorder = recording::RunRecorder::create(recording_config(config, rectifier->geometry(), options.out), arena);
  if (!recorder) {
    const bool is_ours =
        recorder.error().code == ErrorCode::kInvalidConfig || recorder.error().code == ErrorCode::kCapacity;
    return is_ours ? failure(recorder.error())
                   : tl::unexpected(Failure{ExitCode::kCannotCreate, recorder.error().message});
  }
  Chain chain{std::move(*camera), *rectifier, std::move(masks), std::move(*pipeline), std::move(*recorder), {}, {}, {}};
  chain.publishing = std::move(published);
  if (const Outcome<void> added = add_extras(chain, setup, options, arena); !added) {
    return tl::unexpected(added.error());
  }
  return chain;
}

// A recording waits for nobody, and would be over before whoever makes masks has been found.
void wait_for_masks(const Chain& chain) {
  constexpr int kPatience_s = 10;
  const auto give_up = std::chrono::steady_clock::now() + std::chrono::seconds(kPatience_s);
  while (interrupted_by() == 0 && !chain.masks->wait_for_sender(std::chrono::milliseconds(100))) {
    if (std::chrono::steady_clock::now() > give_up) {
      print_warning(
          "nobody sends masks; start the process that does in the same DDS domain and for the same "
          "dds.device, such as `kinetrace masks`. Going on without");
      return;
    }
  }
}

// Recording must not stop anything else.
void record_raw(Chain& chain, const StereoFrame& frame, RunReport& report) {
  if (!chain.raw) {
    return;
  }
  if (chain.waits_for_disk) {
    chain.raw->wait_for_room();
  }
  chain.raw->offer(frame);
  if (const std::optional<Error> stopped = chain.raw->stopped_by()) {
    report.warn_now(raw_stopped(*stopped));
    report.health.note(HealthReason::kRecordingStopped);
    chain.raw_ended = std::move(chain.raw);
  }
}

void hand_over(Chain& chain, const FrameResult& result, StageClock& clock, HealthMonitor& health) {
  if (!chain.publishing) {
    return;
  }
  const StageScope scope(&clock, Stage::kPublish);
  health.note(HealthReason::kNotPublished, chain.publishing->is_connected() ? 0 : 1);
  chain.publishing->offer_health(health, result.counters);
  chain.publishing->offer(result);
}

/// What the thread that processes and the one that captures both look at.
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

/// From a rectified pair to results recorded and on their way.
Status process_pair(Chain& chain, const RectifiedPair& pair, StageClock& clock, HealthMonitor& health,
                    Progressed& progressed) {
  const Result<const FrameResult*> result = chain.pipeline.process(pair, &clock);
  if (!result) {
    return tl::unexpected(result.error());
  }
  health.observe((*result)->newest);
  hand_over(chain, **result, clock, health);
  clock.end_frame();
  Status recorded = chain.recorder.record(**result);
  progressed.set({.frames = progressed.get().frames + 1,
                  .objects_now = static_cast<int>((*result)->newest.objects.size()),
                  .counters = (*result)->counters,
                  .allocations = allocation_counts()});
  chain.service->progress(steady_time_ns());
  if (chain.publishing) {
    chain.publishing->send();
  }
  return recorded;
}

/// From a camera's frame to a rectified pair, and the raw images to the disk.
Result<RectifiedPair> prepare(Chain& chain, const StereoFrame& frame, StageClock& clock, RunReport& report) {
  record_raw(chain, frame, report);
  const StageScope scope(&clock, Stage::kRectify);
  Result<RectifiedPair> pair = chain.rectifier.process(frame);
  if (pair && chain.pairing) {
    chain.pairing->process(*pair, report.health);
  }
  return pair;
}

/// A run's frames, one after the other in one thread or with processing beside capture.
class FramePlayer {
 public:
  FramePlayer(Chain& chain, RunReport& report) : chain_(chain), report_(report) {}

  /// Live from now on. Errors: those of LiveRun::create.
  Status go_live(const AppConfig& config, const CameraSetup& setup, double rate_hz, Arena& arena) {
    capture_clock_ = std::make_unique<StageClock>();
    LiveRun::Processing processing{.process =
                                       [this](const RectifiedPair& pair) {
                                         clock_->begin_frame();
                                         return process_pair(chain_, pair, *clock_, report_.health, progressed_);
                                       },
                                   .idle = [this] { tell_health(); },
                                   .limit = [this](const Effort& effort) { chain_.pipeline.limit(effort); },
                                   .max_objects = config.pipeline.tracking.max_objects};
    auto live = LiveRun::create(config.live, rate_hz, !setup.live, chain_.rectifier.geometry(), std::move(processing),
                                report_.health, arena);
    if (!live) {
      return tl::unexpected(live.error());
    }
    live_ = std::move(*live);
    return {};
  }

  Status play(const StereoFrame& frame) {
    if (live_) {
      live_->await(frame);
    }
    StageClock& clock = capture_clock();
    clock.begin_frame();
    const Result<RectifiedPair> pair = prepare(chain_, frame, clock, report_);
    if (!pair) {
      return tl::unexpected(pair.error());
    }
    if (!live_) {
      return process_pair(chain_, *pair, clock, report_.health, progressed_);
    }
    clock.end_frame();
    Status offered = live_->offer(*pair);
    allocations_at_last_offer_ = allocation_counts();
    return offered;
  }

  /// While no frame comes. Live, the other thread tells health.
  void pass_silence() {
    // Waiting for a camera that has gone, or is silent, is what a run is to do then. While frames come, only results
    // count.
    if (report_.health.camera() != hal::CameraState::kStreaming) {
      chain_.service->progress(steady_time_ns());
    }
    if (!live_) {
      tell_health();
    }
  }
  /// After the last frame. Errors: those of processing what waited.
  Status finish() { return live_ ? live_->finish() : Status{}; }

  [[nodiscard]] Processed processed() const {
    Processed processed = progressed_.get();
    if (live_) {
      // The last pair is processed while capture ends already.
      processed.allocations = allocations_at_last_offer_;
    }
    return processed;
  }
  [[nodiscard]] StageClock& capture_clock() noexcept { return capture_clock_ ? *capture_clock_ : *clock_; }
  [[nodiscard]] const StageClock& clock() const noexcept { return *clock_; }
  /// Null if not live.
  [[nodiscard]] const LiveRun* live() const noexcept { return live_.get(); }

 private:
  void tell_health() {
    if (chain_.publishing) {
      chain_.publishing->offer_health(report_.health, progressed_.get().counters);
    }
  }

  Chain& chain_;
  RunReport& report_;
  Progressed progressed_;
  std::unique_ptr<StageClock> clock_ = std::make_unique<StageClock>();
  AllocationCounts allocations_at_last_offer_;
  std::unique_ptr<StageClock> capture_clock_;  ///< Null: the same.
  std::unique_ptr<LiveRun> live_;              ///< Last, so that its thread ends first.
};

Status settle(Chain& chain) {
  while (const FrameResult* result = chain.pipeline.drain()) {
    if (Status status = chain.recorder.record(*result); !status) {
      return status;
    }
    if (chain.publishing) {
      chain.publishing->offer_settled(*result);
    }
  }
  return {};
}

Outcome<RunReport> run(const RunOptions& options) {
  Result<AppConfig> config = load_config(options.config, options.segmentation);
  if (!config) {
    return failure(config.error());
  }
  const Outcome<CameraSetup> setup = camera_setup(options.source);
  if (!setup) {
    return tl::unexpected(setup.error());
  }
  std::unique_ptr<PublishingSetup> publishing;
  if (!options.publish.empty()) {
    auto checked = publishing_setup(options.publish, config->pipeline.tracking.max_objects);
    if (!checked) {
      return tl::unexpected(checked.error());
    }
    publishing = std::move(*checked);
  } else if (config->pipeline.segmentation.mode == segmentation::SegmentationMode::kDds) {
    return tl::unexpected(Failure{ExitCode::kUsage,
                                  "segmentation dds needs --publish FILE: it says in which DDS domain "
                                  "and for which device masks come"});
  }
  const Result<MemoryPlan> plan = plan_memory(*config, *setup, options.raw, publishing.get());
  if (!plan) {
    return failure(plan.error());
  }
  if (const Status fits = check_budget(*plan, config->pipeline.memory, publishing.get()); !fits) {
    return failure(fits.error());
  }
  Arena arena(plan->total_bytes());
  Outcome<Chain> chain = make_chain(*config, *setup, publishing.get(), options, arena);
  if (!chain) {
    return tl::unexpected(chain.error());
  }
  hal::StereoCamera& camera = *chain->camera.camera;
  if (const Status begun = first_failure({camera.open(), camera.start()}); !begun) {
    return failure(begun.error());
  }

  ConfigFields settings = fields_of(*config);
  if (publishing) {
    const ConfigFields more = publishing->fields();
    settings.insert(settings.end(), more.begin(), more.end());
  }
  RunReport report(options, *setup, to_json(settings));
  FramePlayer player(*chain, report);
  if (is_live(config->live, *setup)) {
    if (const Status live = player.go_live(*config, *setup, camera.info().nominal_rate_hz, arena); !live) {
      return failure(live.error());
    }
  }
  std::optional<std::int64_t> expected = camera.info().frame_count;
  if (options.until.max_frames > 0) {
    expected = std::min<std::int64_t>(options.until.max_frames, expected.value_or(options.until.max_frames));
  }
  Progress progress(!options.quiet, expected);
  const CameraLoop loop{camera, options.until, setup->is_camera, report.health, progress, &player.capture_clock(), [&] {
                          player.pass_silence();
                        }};
  const std::function<Status(const StereoFrame&)> visit = [&](const StereoFrame& frame) {
    Status done = player.play(frame);
    const Processed so_far = player.processed();
    progress.show(so_far.frames, so_far.objects_now);
    return done;
  };
  catch_interrupts();
  if (chain->masks && !setup->is_camera) {
    wait_for_masks(*chain);
  }
  report.start();
  Status played = play_camera(loop, visit);
  progress.clear();
  if (const Status processed = player.finish(); played && !processed) {
    played = processed;
  }
  chain->service->stopping();
  // What was computed is written, whatever ended the run.
  if (const Status settled = settle(*chain); played && !settled) {
    played = settled;
  }
  report.finish(chain->camera, player.processed(), player.capture_clock(), player.clock(), played);
  if (player.live() != nullptr) {
    report.add_live(player.live()->summary());
  }
  if (chain->publishing) {
    chain->publishing->finish();
    report.add_published(*chain->publishing);
  }
  if (chain->masks) {
    report.add_masks(chain->masks->counters());
  }
  for (const auto* raw : {&chain->raw, &chain->raw_ended}) {
    if (*raw) {
      (*raw)->finish();
      report.add_raw(**raw);
    }
  }
  if (const Status written = chain->recorder.finish(report.summary()); played && !written) {
    played = written;
  }
  if (!played) {
    return failure(played.error());
  }
  return report;
}

}  // namespace

int run_command(const RunOptions& options) {
  const Outcome<RunReport> outcome = run(options);
  if (!outcome) {
    return report(outcome.error());
  }
  outcome->print();
  return outcome->summary().exit_status;
}

}  // namespace kinetrace::app
