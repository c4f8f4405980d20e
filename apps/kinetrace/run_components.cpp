#include "run_components.hpp"

#include <utility>

#include "kinetrace/hal/input_monitor.hpp"
#include "memory.hpp"

namespace kinetrace::app {
namespace {

// What is there only where it is asked for.
Outcome<void> add_extras(Chain& chain, const CameraSetup& setup, const RunOptions& options, Arena& arena) {
  if (!options.raw.out.empty()) {
    const double rate_hz = setup.live ? setup.live->left.rate_hz : setup.dataset->nominal_rate_hz;
    auto raw = RecordingThread::create(raw_recorder_config(options.raw, setup.calibration, rate_hz), arena);
    if (!raw) {
      return Unexpected(raw.error());
    }
    chain.raw = std::move(*raw);
    chain.waits_for_disk = !setup.live;
  }
  if (chain.masks) {
    chain.publishing->receive_masks(*chain.masks);
  }
  return {};
}

}  // namespace

Outcome<Chain> make_chain(const AppConfig& config, const CameraSetup& setup, const PublishingSetup* publishing,
                          std::unique_ptr<NetworkThread> network, const RunOptions& options, Arena& arena) {
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
  const auto monitor =
      hal::InputMonitor::create({}, rectifier->geometry().width_px, rectifier->geometry().height_px, arena);
  if (!monitor) {
    return failure(monitor.error());
  }
  InputWatch input(*monitor, PairingKeeper(camera->live), config.input.unusable,
                   {setup.images, setup.calibration.source});
  auto workers = std::make_unique<WorkerThreads>(config.processing.workers());
  auto pipeline = pipeline::Pipeline::create(config.pipeline, rectifier->geometry(), arena,
                                             {.external = masks.get(), .network = network.get()}, workers.get());
  if (!pipeline) {
    return failure(pipeline.error());
  }
  std::unique_ptr<RunPublishing> published;
  if (publishing != nullptr) {
    auto started = publishing->start(rectifier->geometry(), arena);
    if (!started) {
      return Unexpected(started.error());
    }
    published = std::move(*started);
  }
  // Last, so that nothing is made or replaced in the run folder unless everything else is ready.
  recording::RecordingConfig recording = recording_config(config, rectifier->geometry(), options.out);
  recording.images = options.images;
  recording.is_rectified = rectifier->passes_through();
  auto recorder = recording::RunRecorder::create(recording, arena);
  if (!recorder) {
    const bool is_ours =
        recorder.error().code == ErrorCode::kInvalidConfig || recorder.error().code == ErrorCode::kCapacity;
    return is_ours ? failure(recorder.error()) : Unexpected(Failure{ExitCode::kCannotCreate, recorder.error().message});
  }
  Chain chain{std::move(*camera),
              *rectifier,
              std::move(workers),
              std::move(network),
              std::move(masks),
              std::move(*pipeline),
              std::move(*recorder),
              std::move(input),
              {},
              {},
              {}};
  chain.publishing = std::move(published);
  if (config.pipeline.segmentation.mode == segmentation::SegmentationMode::kMasks) {
    chain.mask_files.emplace(config.input.unusable);
  }
  if (const Outcome<void> added = add_extras(chain, setup, options, arena); !added) {
    return Unexpected(added.error());
  }
  return chain;
}

}  // namespace kinetrace::app
