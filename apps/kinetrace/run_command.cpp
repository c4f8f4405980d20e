#include <algorithm>
#include <chrono>
#include <functional>
#include <memory>
#include <optional>
#include <utility>

#include "app_config.hpp"
#include "camera_loop.hpp"
#include "camera_setup.hpp"
#include "commands.hpp"
#include "config_file.hpp"
#include "frame_processor.hpp"
#include "interrupt.hpp"
#include "kinetrace/core/config_check.hpp"
#include "memory.hpp"
#include "messages.hpp"
#include "network_setup.hpp"
#include "progress.hpp"
#include "run_components.hpp"
#include "run_publishing.hpp"
#include "run_report.hpp"
#include "thread_stacks.hpp"

namespace kinetrace::app {
namespace {

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

Status settle(Chain& chain, RunReport& report) {
  while (const FrameResult* result = chain.pipeline.drain()) {
    report.add_settled(result->settled);
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
    return Unexpected(setup.error());
  }
  std::unique_ptr<PublishingSetup> publishing;
  if (!options.publish.empty()) {
    auto checked = publishing_setup(options.publish, config->pipeline.tracking.max_objects);
    if (!checked) {
      return Unexpected(checked.error());
    }
    publishing = std::move(*checked);
  } else if (config->pipeline.segmentation.mode == segmentation::SegmentationMode::kDds) {
    return Unexpected(Failure{ExitCode::kUsage,
                              "segmentation dds needs --publish FILE: it says in which DDS domain "
                              "and for which device masks come"});
  }
  const auto geometry = hal::Rectifier::rectified_geometry(setup->calibration, config->rectification);
  if (!geometry) {
    return failure(geometry.error());
  }
  Result<std::unique_ptr<NetworkThread>> network = start_network(*config, *geometry, !is_live(config->live, *setup));
  if (!network) {
    return failure(network.error());
  }
  const Result<RunMemory> plan = plan_memory(*config, *setup, options.raw, publishing.get(), network->get());
  if (!plan) {
    return failure(plan.error());
  }
  if (const Status fits = check_budget(*plan, config->pipeline.memory); !fits) {
    return failure(fits.error());
  }
  if (const Status limited = limit_thread_stacks(); !limited) {
    return failure(limited.error());
  }
  Arena arena(plan->arena.total_bytes());
  Outcome<Chain> chain = make_chain(*config, *setup, publishing.get(), std::move(*network), options, arena);
  if (!chain) {
    return Unexpected(chain.error());
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
  RunReport report(options, *setup, config->pipeline, to_json(settings));
  if (const auto caution = network_caution(*config, setup->folder)) {
    report.warn_now(*caution);
  }
  report.set_memory(*plan, config->pipeline.memory);
  if (const Status begun = chain->recorder.begin(report.summary()); !begun) {
    return failure(begun.error());
  }
  FrameProcessor player(*chain, report);
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
  const CameraLoop loop{camera,   options.until,           setup->is_camera,         report.health,
                        progress, &player.capture_clock(), [&] {
                          player.on_idle(); }};
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
  if (const Status settled = settle(*chain, report); played && !settled) {
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
  if (chain->network) {
    report.add_network(*chain->network);
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
