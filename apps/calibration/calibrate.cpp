#include "calibrate.hpp"

#include <algorithm>
#include <cstdio>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "calibrate_self.hpp"
#include "calibration_report.hpp"
#include "camera/camera_loop.hpp"
#include "camera/camera_setup.hpp"
#include "cli/interrupt.hpp"
#include "cli/messages.hpp"
#include "guidance_line.hpp"
#include "kinetrace/core/files.hpp"
#include "target_calibration.hpp"
#include "target_drawing.hpp"

namespace kinetrace::calibration {
namespace {

using app::CalibrateOptions;
using app::CameraSetup;
using app::failure;
using app::Outcome;

Lens lens_named(const std::string& name) {
  const auto* const found =
      std::find_if(kLensNames.begin(), kLensNames.end(), [&name](const auto& known) { return known.first == name; });
  return found == kLensNames.end() ? Lens::kRadialTangential : found->second;
}

// Moving targets are blurred, and displaced between images of cameras that are not exactly synchronised. A live camera
// delivers enough images to wait for rest; recordings are used as they are.
class StillnessGate {
 public:
  explicit StillnessGate(bool enabled) : enabled_(enabled) {}

  bool is_still(const BoardView& view) {
    double moved = 0.0;
    int common = 0;
    for (const Corner& corner : view.left) {
      const auto before = std::find_if(last_.begin(), last_.end(), [&](const Corner& c) { return c.id == corner.id; });
      if (before != last_.end()) {
        moved += (before->px - corner.px).norm();
        ++common;
      }
    }
    last_ = view.left;
    constexpr double kStill_px = 2.0;
    return !enabled_ || (common > 0 && moved / common < kStill_px);
  }

 private:
  bool enabled_;
  std::vector<Corner> last_;
};

EstimationOptions estimation_options(const CalibrateOptions& options, const CameraSetup& setup) {
  return {.lens = lens_named(options.lens),
          .width_px = setup.calibration.raw_width_px(),
          .height_px = setup.calibration.raw_height_px()};
}

// A live session is complete if no view is missing and the views give a calibration.
class CompletenessCheck {
 public:
  CompletenessCheck(const Target& target, const EstimationOptions& options) : target_(target), options_(options) {}

  bool is_complete(const ViewCollector& views) {
    constexpr std::size_t kViewsBetween = 5;
    if (views.views().size() < next_try_ || !views.assess().missing.empty()) {
      return false;
    }
    next_try_ = views.views().size() + kViewsBetween;
    return calibrate(target_, views, options_).has_value();
  }

 private:
  const Target& target_;
  EstimationOptions options_;
  std::size_t next_try_ = 0;
};

Status collect(const CalibrateOptions& options, const CameraSetup& setup, hal::StereoCamera& camera,
               const Target& target, TargetDetector& detector, ViewCollector& views) {
  const bool is_live = setup.live.has_value();
  GuidanceLine guidance(!options.quiet);
  StillnessGate gate(is_live);
  CompletenessCheck check(target, estimation_options(options, setup));
  app::HealthMonitor health;
  app::Progress progress(false, std::nullopt);
  bool is_complete = false;
  const app::CameraLoop loop{camera, options.until, setup.is_camera, health, progress};
  Status played = play_camera(loop, [&](const StereoFrame& frame) -> Status {
    BoardView view = detector.detect_pair(frame.left, frame.right);
    view.frame_index = frame.frame_index;
    if (!gate.is_still(view)) {
      return {};
    }
    const Offer offer = views.offer(std::move(view));
    guidance.show(views, offer);
    is_complete = is_live && offer == Offer::kTaken && check.is_complete(views);
    return is_complete ? Status(fail(ErrorCode::kEndOfStream, "nothing is missing")) : Status();
  });
  guidance.clear();
  return is_complete ? Status() : played;
}

Outcome<std::unique_ptr<ViewCollector>> collected(const CalibrateOptions& options, const CameraSetup& setup,
                                                  const Target& target) {
  auto detector = make_detector(target);
  if (!detector) {
    return failure(detector.error());
  }
  Arena arena(setup.required_bytes() + Arena::kAlignment);
  auto camera = setup.make(arena);
  if (!camera) {
    return failure(camera.error());
  }
  for (const Status& begun : {camera->camera->open(), camera->camera->start()}) {
    if (!begun) {
      return failure(begun.error());
    }
  }
  auto views = std::make_unique<ViewCollector>(target, lens_named(options.lens), setup.calibration.raw_width_px(),
                                               setup.calibration.raw_height_px());
  if (const Status played = collect(options, setup, *camera->camera, target, **detector, *views); !played) {
    return failure(played.error());
  }
  return views;
}

Status write_files(const CalibrateOptions& options, const TargetCalibration& calibration, const ViewCollector& views,
                   const ReportSource& source) {
  Status written = write_calibration_files(calibration.estimate.rig, options.out, remarks(calibration, source));
  if (written) {
    written = replace_file(options.out / "calibration.json", report_json(calibration, views, source));
  }
  return written ? write_picture(calibration, views, options.out / "calibration.png") : written;
}

Status draw_target(const CalibrateOptions& options) {
  if (Status free = check_same_kind(options.draw, {"drawing of a target", &is_target_svg}); !free) {
    return free;
  }
  return parse_target(options.target).and_then(target_svg).and_then([&options](const std::string& svg) {
    return replace_file(options.draw, svg);
  });
}

Outcome<TargetCalibration> carry_out(const CalibrateOptions& options) {
  const auto target = parse_target(options.target);
  if (!target) {
    return failure(target.error());
  }
  app::catch_interrupts();
  const Outcome<CameraSetup> setup = app::camera_setup(options.source);
  if (!setup) {
    return Unexpected(setup.error());
  }
  if (const Status usable = check_output_folder(options.out); !usable) {
    return Unexpected(app::Failure{app::ExitCode::kCannotCreate, usable.error().message});
  }
  const auto views = collected(options, *setup, *target);
  if (!views) {
    return Unexpected(views.error());
  }
  auto calibration = calibrate(*target, **views, estimation_options(options, *setup));
  if (!calibration) {
    return failure(calibration.error());
  }
  const ReportSource source{setup->images, target->description(), options.lens};
  if (const Status written = write_files(options, *calibration, **views, source); !written) {
    return failure(written.error());
  }
  return std::move(*calibration);
}

}  // namespace

int calibrate_command(const CalibrateOptions& options) {
  if (!options.draw.empty()) {
    const Status drawn = draw_target(options);
    return drawn ? 0 : app::report(app::to_failure(drawn.error()));
  }
  if (options.out.empty() ||
      (options.self.empty() && options.source.dataset.empty() && options.source.camera.empty())) {
    return app::report({app::ExitCode::kUsage, "calibrate needs --dataset, --camera or --self, and --out; see --help"});
  }
  if (!options.self.empty()) {
    return calibrate_self_command(options);
  }
  const Outcome<TargetCalibration> calibration = carry_out(options);
  if (!calibration) {
    return app::report(calibration.error());
  }
  for (const std::string& warning : calibration->warnings) {
    app::print_warning(warning);
  }
  if (!options.quiet) {
    for (const std::string& line : report_lines(*calibration)) {
      std::printf("%s\n", line.c_str());
    }
    std::printf("written  %s\n", (options.out / "calibration.yaml").c_str());
  }
  return 0;
}

}  // namespace kinetrace::calibration
