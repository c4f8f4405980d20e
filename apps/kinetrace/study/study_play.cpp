#include "study/study_play.hpp"

#include <chrono>
#include <utility>

#include "cli/interrupt.hpp"
#include "cli/messages.hpp"
#include "kinetrace/hal/file_stereo_camera.hpp"
#include "kinetrace/hal/rectifier.hpp"
#include "kinetrace/pipeline/pipeline.hpp"
#include "live/worker_threads.hpp"
#include "plan/memory.hpp"
#include "plan/network_setup.hpp"

namespace kinetrace::app {
namespace {

constexpr std::chrono::milliseconds kFrameTimeout(2000);

/// All components except the camera.
struct Processing {
  WorkerThreads& workers;
  hal::Rectifier& rectifier;
  pipeline::Pipeline& pipeline;
};

// From rectification to trajectories; `clock` may be null.
Result<const FrameResult*> process(const StereoFrame& frame, Processing& processing, StageClock* clock) {
  if (clock != nullptr) {
    clock->begin_frame();
  }
  const Result<RectifiedPair> pair = [&] {
    const StageScope scope(clock, Stage::kRectify);
    return processing.rectifier.process(frame, &processing.workers);
  }();
  Result<const FrameResult*> result = pair ? processing.pipeline.process(*pair, clock) : Unexpected(pair.error());
  if (clock != nullptr) {
    clock->end_frame();
  }
  return result;
}

Status play(hal::FileStereoCamera& camera, Processing processing,
            const std::function<Status(const FrameResult&)>& visit, StageClock* clock) {
  for (const Status& status : {camera.open(), camera.start()}) {
    if (!status) {
      return status;
    }
  }
  while (interrupted_by() == 0) {
    const Result<StereoFrame> frame = [&] {
      const StageScope scope(clock, Stage::kCapture);
      return camera.next(kFrameTimeout);
    }();
    if (!frame && frame.error().code == ErrorCode::kEndOfStream) {
      break;
    }
    const Result<const FrameResult*> result = frame ? process(*frame, processing, clock) : Unexpected(frame.error());
    Status visited = result ? visit(**result) : Unexpected(result.error());
    if (!visited) {
      return visited;
    }
  }
  while (const FrameResult* result = processing.pipeline.drain()) {
    if (Status visited = visit(*result); !visited) {
      return visited;
    }
  }
  return {};
}

}  // namespace

Status play_recording(const hal::Dataset& dataset, AppConfig& config,
                      const std::function<Status(const FrameResult&)>& visit, StageClock* clock) {
  const auto geometry = hal::Rectifier::rectified_geometry(dataset.calibration, config.rectification);
  if (!geometry) {
    return Unexpected(geometry.error());
  }
  const PlanRun plan_run = [&](const AppConfig& planned, const NetworkThread* network) {
    return plan_memory(planned, recording_setup(dataset), {}, nullptr, network);
  };
  const Result<StartedNetwork> network = start_network(config, *geometry, true, plan_run);
  if (!network) {
    return Unexpected(network.error());
  }
  if (network->why_none) {
    print_warning(*network->why_none);
  }
  const Result<RunMemory> plan = plan_run(config, network->thread.get());
  if (!plan) {
    return Unexpected(plan.error());
  }
  Arena arena(plan->arena.total_bytes());
  auto camera = hal::FileStereoCamera::create(dataset, {}, arena);
  if (!camera) {
    return Unexpected(camera.error());
  }
  auto rectifier = hal::Rectifier::create(dataset.calibration, config.rectification, arena);
  if (!rectifier) {
    return Unexpected(rectifier.error());
  }
  WorkerThreads workers(config.processing.workers());
  auto pipeline = pipeline::Pipeline::create(config.pipeline, rectifier->geometry(), arena,
                                             {.external = nullptr, .network = network->thread.get()}, &workers);
  if (!pipeline) {
    return Unexpected(pipeline.error());
  }
  return play(*camera, {workers, *rectifier, *pipeline}, visit, clock);
}

}  // namespace kinetrace::app
