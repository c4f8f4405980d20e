#include "run/run_setup.hpp"

#include <algorithm>
#include <utility>

#include "camera/recording_thread.hpp"
#include "config/config_file.hpp"
#include "kinetrace/core/files.hpp"
#include "kinetrace/hal/rectifier.hpp"
#include "kinetrace/hal/rig_calibration.hpp"
#include "plan/network_setup.hpp"

namespace kinetrace::app {
namespace {

Outcome<std::unique_ptr<PublishingSetup>> publishing_of(const RunOptions& options, const AppConfig& config) {
  if (options.publish.empty() && config.pipeline.segmentation.mode == segmentation::SegmentationMode::kDds) {
    return Unexpected(Failure{ExitCode::kUsage,
                              "segmentation dds needs --publish FILE: it says in which DDS domain "
                              "and for which device masks come"});
  }
  return optional_publishing(options.publish, config.pipeline.tracking.max_objects);
}

// A run that is refined afterwards uses more features, since it need not keep up with a camera: more points account for
// most of the gain of a whole recording over a window. --set decides otherwise.
void prepare_refinement(AppConfig& config) {
  constexpr int kFeatures = 4000;  // The number of slots.
  constexpr int kBackgroundFeatures = 2500;
  constexpr int kBackgroundPoints = 2200;
  constexpr int kBucket_px = 13;  // As many buckets as background features, in 1242x375 pixels.
  config.output.observations = true;
  // Nothing is late for a recording: each frame waits for its own masks.
  config.pipeline.segmentation.onnx.latency_frames = 0;
  features::FeatureConfig& features = config.pipeline.features;
  features.max_features = std::max(features.max_features, kFeatures);
  features.max_background_features = std::max(features.max_background_features, kBackgroundFeatures);
  features.bucket_px = std::min(features.bucket_px, kBucket_px);
  config.pipeline.background.max_points = std::max(config.pipeline.background.max_points, kBackgroundPoints);
}

// The calibration is written at the end of the run: its place is checked before. A second calibration among a
// recording's files could make it unreadable.
Status check_calibration_place(const RunOptions& options, const CameraSetup& camera) {
  const std::filesystem::path& file = options.save_calibration;
  if (file.empty()) {
    return {};
  }
  for (const auto& [folder, what] :
       {std::pair(camera.folder, "the recording "), std::pair(options.out, "the run folder ")}) {
    if (!folder.empty() && is_inside(file, folder)) {
      return fail(ErrorCode::kOccupied,
                  file.string() + ": lies in " + what + folder.string() + "; name another place for the calibration");
    }
  }
  return hal::check_calibration_place(file, hal::CalibrationFormat::kOpencv);
}

}  // namespace

Outcome<RunSetup> RunSetup::create(const RunOptions& options) {
  const bool is_refined = !options.refine.empty();
  Result<AppConfig> config =
      load_config(options.config, options.segmentation, is_refined ? prepare_refinement : nullptr);
  if (!config) {
    return failure(config.error());
  }
  if (is_refined && !config->output.observations) {
    return Unexpected(Failure{ExitCode::kUsage,
                              "--refine: --set output.observations=false leaves out what a refinement needs; leave "
                              "that setting out"});
  }
  if (!options.save_calibration.empty() && config->pipeline.calibration.mode == rig::RefineMode::kOff) {
    return Unexpected(
        Failure{ExitCode::kUsage, "--save-calibration: calibration.refine is off; set it to on or check"});
  }
  Outcome<CameraSetup> camera = camera_setup(options.source);
  if (!camera) {
    return Unexpected(camera.error());
  }
  if (const Status place = check_calibration_place(options, *camera); !place) {
    return failure(place.error());
  }
  // An earlier run in the run folder is removed before the raw recording begins: that must not fail then.
  if (!options.raw.out.empty()) {
    const auto raw = raw_recorder_config(options.raw, camera->calibration, camera->rate_hz());
    if (const Outcome<void> can = RecordingThread::check(raw, camera->folder); !can) {
      return Unexpected(can.error());
    }
  }
  Outcome<std::unique_ptr<PublishingSetup>> publishing = publishing_of(options, *config);
  if (!publishing) {
    return Unexpected(publishing.error());
  }
  const auto geometry = hal::Rectifier::rectified_geometry(camera->calibration, config->rectification);
  if (!geometry) {
    return failure(geometry.error());
  }
  const PlanRun plan_run = [&](const AppConfig& planned, const NetworkThread* network) {
    return plan_memory(planned, *camera, options.raw, publishing->get(), network);
  };
  Result<StartedNetwork> network = start_network(*config, *geometry, !app::is_live(config->live, *camera), plan_run);
  if (!network) {
    return failure(network.error());
  }
  Result<RunMemory> memory = plan_run(*config, network->thread.get());
  if (!memory) {
    return failure(memory.error());
  }
  if (const Status fits = check_budget(*memory, config->pipeline.memory); !fits) {
    return failure(fits.error());
  }
  return RunSetup{.options = options,
                  .config = std::move(*config),
                  .camera = std::move(*camera),
                  .publishing = std::move(*publishing),
                  .network = std::move(network->thread),
                  .why_no_network = std::move(network->why_none),
                  .memory = std::move(*memory)};
}

std::string RunSetup::settings_json() {
  return to_json(all_fields(fields_of(config), publishing.get()));
}

}  // namespace kinetrace::app
