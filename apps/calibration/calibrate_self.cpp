#include "calibrate_self.hpp"

#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <string>
#include <utility>
#include <vector>

#include "calibration_report.hpp"
#include "camera/camera_setup.hpp"
#include "cli/messages.hpp"
#include "kinetrace/core/arena.hpp"
#include "kinetrace/core/files.hpp"
#include "kinetrace/hal/file_stereo_camera.hpp"
#include "self/self_report.hpp"

namespace kinetrace::calibration {
namespace {

using app::CalibrateOptions;
using app::failure;
using app::Outcome;
using self_calibration::SelfCalibration;

Result<SelfCalibration> calibrated(const CalibrateOptions& options, const hal::Dataset& dataset) {
  Arena arena(hal::FileStereoCamera::required_bytes(dataset, {}) + Arena::kAlignment);
  auto camera = hal::FileStereoCamera::create(dataset, {}, arena);
  if (!camera) {
    return Unexpected(camera.error());
  }
  const std::size_t most =
      options.until.max_frames > 0 ? static_cast<std::size_t>(options.until.max_frames) : dataset.frames.size();
  const self_calibration::FrameSource frames{std::min(most, dataset.frames.size()),
                                             [&](std::size_t place) { return camera->frame_at(place); }};
  self_calibration::SelfCalibrationOptions estimation;
  estimation.baseline_m = options.baseline_m;
  if (!options.quiet) {
    estimation.progress = [](const std::string& step) { std::fprintf(stderr, "%s ...\n", step.c_str()); };
  }
  return self_calibrate(frames, estimation);
}

Status write_files(const CalibrateOptions& options, const SelfCalibration& result, const std::string& images) {
  const Status written = write_calibration_files(result.calibration, options.out, remarks(result, images));
  return written ? replace_file(options.out / "calibration.json", report_json(result, images)) : written;
}

Outcome<SelfCalibration> carry_out(const CalibrateOptions& options) {
  app::SourceOptions source = options.source;
  source.dataset = options.self;
  const Outcome<app::CameraSetup> setup = app::camera_setup(source);
  if (!setup) {
    return Unexpected(setup.error());
  }
  if (const Status usable = check_output_folder(options.out); !usable) {
    return Unexpected(app::Failure{app::ExitCode::kCannotCreate, usable.error().message});
  }
  auto result = calibrated(options, *setup->dataset);
  if (!result) {
    return failure(result.error());
  }
  if (const Status written = write_files(options, *result, setup->images); !written) {
    return failure(written.error());
  }
  return std::move(*result);
}

}  // namespace

int calibrate_self_command(const CalibrateOptions& options) {
  const Outcome<SelfCalibration> result = carry_out(options);
  if (!result) {
    return app::report(result.error());
  }
  if (!options.quiet) {
    for (const std::string& line : self_calibration::report_lines(*result)) {
      std::printf("%s\n", line.c_str());
    }
    std::printf("written  %s\n", (options.out / "calibration.yaml").c_str());
  }
  return 0;
}

}  // namespace kinetrace::calibration
