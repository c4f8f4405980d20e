#include <algorithm>
#include <chrono>
#include <memory>
#include <optional>
#include <utility>

#include "app_config.hpp"
#include "commands.hpp"
#include "config_file.hpp"
#include "interrupt.hpp"
#include "kinetrace/core/allocation_counter.hpp"
#include "kinetrace/hal/file_stereo_camera.hpp"
#include "kinetrace/hal/rectifier.hpp"
#include "kinetrace/pipeline/pipeline.hpp"
#include "kinetrace/recording/run_recorder.hpp"
#include "memory.hpp"
#include "messages.hpp"
#include "progress.hpp"
#include "run_report.hpp"
#include "stage_clock.hpp"

namespace kinetrace::app {
namespace {

// A recording never waits; this bounds a live camera's silence.
constexpr std::chrono::milliseconds kFrameTimeout(2000);

Outcome<hal::DatasetSpec> dataset_spec(const RunOptions& options) {
  const std::size_t colon = options.dataset.find(':');
  if (colon == std::string::npos || colon + 1 == options.dataset.size()) {
    return tl::unexpected(Failure{
        ExitCode::kUsage, "--dataset " + options.dataset + ": expected LAYOUT:PATH, for example kitti-raw:data/drive"});
  }
  const auto layout = hal::parse_layout(options.dataset.substr(0, colon));
  if (!layout) {
    return failure(layout.error());
  }
  hal::DatasetSpec spec;
  spec.layout = *layout;
  spec.path = options.dataset.substr(colon + 1);
  spec.sequence = options.sequence;
  if (!options.cameras.empty()) {
    spec.cameras = options.cameras == "gray" ? hal::CameraChoice::kGray : hal::CameraChoice::kColor;
  }
  return spec;
}

// The parts of a run, in the order that a frame passes them. All memory is taken when they are made.
struct Chain {
  hal::FileStereoCamera camera;
  hal::Rectifier rectifier;
  pipeline::Pipeline pipeline;
  recording::RunRecorder recorder;
};

Outcome<Chain> make_chain(const AppConfig& config, const hal::Dataset& dataset, const RunOptions& options,
                          Arena& arena) {
  auto camera = hal::FileStereoCamera::create(dataset, {.passes = options.passes}, arena);
  if (!camera) {
    return failure(camera.error());
  }
  auto rectifier = hal::Rectifier::create(dataset.calibration, config.rectification, arena);
  if (!rectifier) {
    return failure(rectifier.error());
  }
  auto pipeline = pipeline::Pipeline::create(config.pipeline, rectifier->geometry(), arena);
  if (!pipeline) {
    return failure(pipeline.error());
  }
  // Last, so that nothing is made or replaced in the run folder unless everything else is ready.
  auto recorder = recording::RunRecorder::create(recording_config(config, rectifier->geometry(), options.out), arena);
  if (!recorder) {
    const bool is_ours =
        recorder.error().code == ErrorCode::kInvalidConfig || recorder.error().code == ErrorCode::kCapacity;
    return is_ours ? failure(recorder.error())
                   : tl::unexpected(Failure{ExitCode::kCannotCreate, recorder.error().message});
  }
  return Chain{std::move(*camera), *rectifier, std::move(*pipeline), std::move(*recorder)};
}

Status play_frame(Chain& chain, const StereoFrame& frame, StageClock& clock, RunReport& report) {
  clock.begin_frame();
  const Result<RectifiedPair> pair = [&] {
    const StageScope scope(&clock, Stage::kRectify);
    return chain.rectifier.process(frame);
  }();
  if (!pair) {
    return tl::unexpected(pair.error());
  }
  const Result<const FrameResult*> result = chain.pipeline.process(*pair, &clock);
  clock.end_frame();
  if (!result) {
    return tl::unexpected(result.error());
  }
  ++report.frames;
  report.objects_now = static_cast<int>((*result)->newest.objects.size());
  report.counters = (*result)->counters;
  Status recorded = chain.recorder.record(**result);
  report.allocations_at_last_frame = allocation_counts();
  return recorded;
}

Status play(Chain& chain, const RunOptions& options, StageClock& clock, Progress& progress, RunReport& report) {
  while (interrupted_by() == 0 && (options.max_frames == 0 || report.frames < options.max_frames)) {
    const Result<StereoFrame> frame = [&] {
      const StageScope scope(&clock, Stage::kCapture);
      return chain.camera.next(kFrameTimeout);
    }();
    if (!frame && frame.error().code == ErrorCode::kEndOfStream) {
      break;
    }
    if (!frame) {
      return tl::unexpected(frame.error());
    }
    if (Status status = play_frame(chain, *frame, clock, report); !status) {
      return status;
    }
    progress.show(report.frames, report.objects_now);
  }
  return {};
}

Status settle(Chain& chain) {
  while (const FrameResult* result = chain.pipeline.drain()) {
    if (Status status = chain.recorder.record(*result); !status) {
      return status;
    }
  }
  return {};
}

Outcome<RunReport> run(const RunOptions& options) {
  const Outcome<hal::DatasetSpec> spec = dataset_spec(options);
  if (!spec) {
    return tl::unexpected(spec.error());
  }
  Result<AppConfig> config = load_config(options.config, options.segmentation);
  if (!config) {
    return failure(config.error());
  }
  const Result<hal::Dataset> dataset = hal::open_dataset(*spec);
  if (!dataset) {
    return failure(dataset.error());
  }
  const Result<MemoryPlan> plan = plan_memory(*config, *dataset);
  if (!plan) {
    return failure(plan.error());
  }
  if (const Status fits = check_budget(*plan, config->pipeline.memory); !fits) {
    return failure(fits.error());
  }
  Arena arena(plan->total_bytes());
  Outcome<Chain> chain = make_chain(*config, *dataset, options, arena);
  if (!chain) {
    return tl::unexpected(chain.error());
  }
  for (const Status& status : {chain->camera.open(), chain->camera.start()}) {
    if (!status) {
      return failure(status.error());
    }
  }

  RunReport report(options, *dataset, to_json(fields_of(*config)));
  const auto clock = std::make_unique<StageClock>();
  std::optional<std::int64_t> expected = chain->camera.info().frame_count;
  if (options.max_frames > 0) {
    expected = std::min<std::int64_t>(options.max_frames, expected.value_or(options.max_frames));
  }
  Progress progress(!options.quiet, expected);
  catch_interrupts();
  report.start();
  Status played = play(*chain, options, *clock, progress, report);
  progress.clear();
  // What was computed is written, whatever ended the run.
  if (const Status settled = settle(*chain); played && !settled) {
    played = settled;
  }
  report.finish(chain->camera, *clock, played);
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
