#include "run/run_components.hpp"

#include <utility>

#include "kinetrace/hal/input_monitor.hpp"
#include "plan/memory.hpp"

namespace kinetrace::app {
namespace {

// Null unless masks come from another process.
std::unique_ptr<MaskMailbox> make_mailbox(const AppConfig& config, const StereoGeometry& geometry, Arena& arena) {
  if (const std::optional<MaskMailboxConfig> wanted = mask_mailbox_config(config, geometry)) {
    return std::make_unique<MaskMailbox>(*wanted, arena);
  }
  return nullptr;
}

Result<InputWatch> make_input_watch(const RunSetup& setup, const GuardedCamera& camera, const StereoGeometry& geometry,
                                    Arena& arena) {
  const auto monitor = hal::InputMonitor::create({}, geometry.width_px, geometry.height_px, arena);
  if (!monitor) {
    return Unexpected(monitor.error());
  }
  return InputWatch(*monitor, PairingKeeper(camera.live), setup.config.input.unusable,
                    {setup.camera.images, setup.camera.calibration.source});
}

// Null unless asked for.
Outcome<std::unique_ptr<RunPublishing>> start_publishing(const PublishingSetup* setup, const StereoGeometry& geometry,
                                                         Arena& arena) {
  return setup == nullptr ? nullptr : setup->start(geometry, arena);
}

std::optional<MaskFileWatch> make_mask_file_watch(const AppConfig& config) {
  const bool from_files = config.pipeline.segmentation.mode == segmentation::SegmentationMode::kMasks;
  return from_files ? std::optional<MaskFileWatch>(config.input.unusable) : std::nullopt;
}

std::optional<MaskFitWatch> make_mask_fit_watch(const AppConfig& config) {
  const segmentation::SegmentationConfig& masks = config.pipeline.segmentation;
  switch (masks.mode) {
    case segmentation::SegmentationMode::kMasks:
      return MaskFitWatch(config.input.unusable, "mask folder " + masks.left_dir);
    case segmentation::SegmentationMode::kDds: return MaskFitWatch(config.input.unusable, "received masks");
    default: return std::nullopt;
  }
}

Outcome<recording::RunRecorder> make_recorder(const RunSetup& setup, const hal::Rectifier& rectifier, Arena& arena) {
  recording::RecordingConfig config = recording_config(setup.config, rectifier.geometry(), setup.options.out);
  config.images = setup.options.images;
  config.is_rectified = rectifier.passes_through();
  config.repeats = setup.camera.passes > 1;
  auto recorder = recording::RunRecorder::create(config, arena);
  if (!recorder) {
    const bool is_ours =
        recorder.error().code == ErrorCode::kInvalidConfig || recorder.error().code == ErrorCode::kCapacity;
    return is_ours ? failure(recorder.error()) : Unexpected(Failure{ExitCode::kCannotCreate, recorder.error().message});
  }
  return std::move(*recorder);
}

// Null unless asked for.
Outcome<std::unique_ptr<RecordingThread>> make_raw(const RunSetup& setup, Arena& arena) {
  const RawOutputOptions& raw = setup.options.raw;
  if (raw.out.empty()) {
    return nullptr;
  }
  return RecordingThread::create(raw_recorder_config(raw, setup.camera.calibration, setup.camera.rate_hz()), arena);
}

}  // namespace

Outcome<RunComponents> make_components(RunSetup& setup, Arena& arena) {
  auto camera = setup.camera.make(arena);
  if (!camera) {
    return failure(camera.error());
  }
  auto rectifier = hal::Rectifier::create(setup.camera.calibration, setup.config.rectification, arena);
  if (!rectifier) {
    return failure(rectifier.error());
  }
  std::unique_ptr<MaskMailbox> masks = make_mailbox(setup.config, rectifier->geometry(), arena);
  Result<InputWatch> input = make_input_watch(setup, *camera, rectifier->geometry(), arena);
  if (!input) {
    return failure(input.error());
  }
  auto workers = std::make_unique<WorkerThreads>(setup.config.processing.workers());
  auto pipeline = pipeline::Pipeline::create(setup.config.pipeline, rectifier->geometry(), arena,
                                             {.external = masks.get(), .network = setup.network.get()}, workers.get());
  if (!pipeline) {
    return failure(pipeline.error());
  }
  auto publishing = start_publishing(setup.publishing.get(), rectifier->geometry(), arena);
  if (!publishing) {
    return Unexpected(publishing.error());
  }
  // Last, so that no folder is changed before all other components are ready.
  auto recorder = make_recorder(setup, *rectifier, arena);
  if (!recorder) {
    return Unexpected(recorder.error());
  }
  auto raw = make_raw(setup, arena);
  if (!raw) {
    return Unexpected(raw.error());
  }
  if (masks) {
    (*publishing)->receive_masks(*masks);
  }
  return RunComponents{.camera = std::move(*camera),
                       .rectifier = *rectifier,
                       .workers = std::move(workers),
                       .network = std::move(setup.network),
                       .masks = std::move(masks),
                       .pipeline = std::move(*pipeline),
                       .recorder = std::move(*recorder),
                       .input = std::move(*input),
                       .mask_files = make_mask_file_watch(setup.config),
                       .mask_fit = make_mask_fit_watch(setup.config),
                       .raw = std::move(*raw),
                       .refines_calibration = setup.config.pipeline.calibration.mode == rig::RefineMode::kOn,
                       .waits_for_disk = !setup.camera.live,
                       .publishing = std::move(*publishing)};
}

}  // namespace kinetrace::app
