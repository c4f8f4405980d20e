#include "run/run_session.hpp"

#include <algorithm>
#include <array>
#include <chrono>
#include <functional>
#include <optional>

#include "camera/camera_loop.hpp"
#include "camera/rig_report.hpp"
#include "cli/interrupt.hpp"
#include "cli/messages.hpp"
#include "cli/progress.hpp"
#include "kinetrace/core/config_check.hpp"
#include "plan/network_setup.hpp"

namespace kinetrace::app {
namespace {

// Without waiting, a short recording could end before a sender of masks is discovered.
void wait_for_masks(MaskMailbox& masks) {
  constexpr int kTimeout_s = 10;
  const auto give_up = std::chrono::steady_clock::now() + std::chrono::seconds(kTimeout_s);
  while (interrupted_by() == 0 && !masks.wait_for_sender(std::chrono::milliseconds(100))) {
    if (std::chrono::steady_clock::now() > give_up) {
      print_warning(
          "no process sends masks; start one in the same DDS domain and for the same "
          "dds.device, such as `kinetrace masks`. Continuing without");
      return;
    }
  }
}

// None if only the user ends the run.
std::optional<std::int64_t> expected_frames(std::optional<std::int64_t> available, const UntilOptions& until) {
  if (until.max_frames == 0) {
    return available;
  }
  return std::min<std::int64_t>(until.max_frames, available.value_or(until.max_frames));
}

}  // namespace

RunSession::RunSession(RunSetup& setup, RunComponents& components)
    : setup_(setup),
      components_(components),
      report_(setup.options, setup.camera, setup.config.pipeline, setup.settings_json()),
      processor_(components, report_) {}

Status RunSession::begin(Arena& arena) {
  hal::StereoCamera& camera = *components_.camera.camera;
  if (Status begun = first_failure({camera.open(), camera.start()}); !begun) {
    return begun;
  }
  if (setup_.why_no_network) {
    report_.warn_now(*setup_.why_no_network);
  }
  if (const auto caution = network_caution(setup_.config, setup_.camera.folder)) {
    const bool was_chosen = setup_.config.pipeline.segmentation.mode == segmentation::SegmentationMode::kOnnx ||
                            !setup_.config.pipeline.segmentation.onnx.model.empty();
    if (was_chosen) {
      report_.warn_now(*caution);
    } else {
      report_.note(*caution);
    }
  }
  report_.set_memory(setup_.memory, setup_.config.pipeline.memory);
  report_.set_geometry(components_.rectifier.geometry());
  if (Status begun = components_.recorder.begin(report_.summary()); !begun) {
    return begun;
  }
  return setup_.is_live() ? processor_.go_live(setup_, camera.info().nominal_rate_hz, arena) : Status{};
}

Status RunSession::play() {
  hal::StereoCamera& camera = *components_.camera.camera;
  const RunOptions& options = setup_.options;
  Progress progress(!options.quiet, expected_frames(camera.info().frame_count, options.until));
  const CameraLoop loop{
      camera, options.until, setup_.camera.is_camera, report_.health, progress, &processor_.capture_clock(), [&] {
        processor_.on_idle();
      }};
  const std::function<Status(const StereoFrame&)> visit = [&](const StereoFrame& frame) {
    Status done = processor_.process(frame);
    const Processed so_far = processor_.processed();
    progress.show(so_far.frames, so_far.objects_now);
    return done;
  };
  catch_interrupts();
  if (components_.masks && !setup_.camera.is_camera) {
    wait_for_masks(*components_.masks);
  }
  report_.start();
  Status played = play_camera(loop, visit);
  progress.clear();
  return played;
}

Status RunSession::finish(Status played) {
  // In the order of the data flow: process the waiting frames, then write, then count.
  played = first_failure({played, processor_.finish()});
  components_.service->stopping();
  played = first_failure({played, finalize()});
  report_.finish(components_.camera, processor_.processed(), processor_.capture_clock(), processor_.clock(), played);
  report_components();
  return first_failure({played, save_calibration(), components_.recorder.finish(report_.summary())});
}

// Records the remaining estimates.
Status RunSession::finalize() {
  while (const FrameResult* result = components_.pipeline.drain()) {
    report_.add_finalised(result->finalised);
    if (Status status = components_.recorder.record(*result); !status) {
      return status;
    }
    if (components_.publishing) {
      components_.publishing->offer_finalised(*result);
    }
  }
  return {};
}

Status RunSession::save_calibration() {
  const std::filesystem::path& path = setup_.options.save_calibration;
  if (path.empty()) {
    return {};
  }
  const RigEstimate rig = processor_.processed().rig;
  if (rig.verdict != RigVerdict::kOff && rig.verdict != RigVerdict::kCorrected) {
    report_.note(path.string() + " is not written: the calibration " +
                 (rig.verdict == RigVerdict::kHolds ? "holds" : "cannot be judged from this motion"));
    return {};
  }
  const Result<hal::RigCalibration> corrected =
      hal::corrected_rig(setup_.camera.calibration, setup_.config.rectification, rig.lasting());
  if (!corrected) {
    return Unexpected(corrected.error());
  }
  const std::array<std::string, 2> remarks{"kinetrace run: " + setup_.camera.calibration.source + ", corrected",
                                           rig_text(rig, components_.rectifier.geometry())};
  return hal::write_rig_calibration(*corrected, path, hal::CalibrationFormat::kOpencv, remarks);
}

void RunSession::report_components() {
  if (processor_.live() != nullptr) {
    report_.add_live(processor_.live()->summary());
  }
  if (components_.publishing) {
    components_.publishing->finish();
    report_.add_published(*components_.publishing);
  }
  if (components_.masks) {
    report_.add_masks(components_.masks->counters());
  }
  if (components_.network) {
    report_.add_network(*components_.network);
  }
  for (const auto* raw : {&components_.raw, &components_.raw_ended}) {
    if (*raw) {
      (*raw)->finish();
      report_.add_raw(**raw);
    }
  }
}

}  // namespace kinetrace::app
