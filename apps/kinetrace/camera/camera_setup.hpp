// Where a run's frames come from, decided before any memory is taken.
#pragma once

#include <cstddef>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "camera/camera_config.hpp"
#include "cli/failure.hpp"
#include "cli/shared_options.hpp"
#include "kinetrace/core/arena.hpp"
#include "kinetrace/hal/dataset.hpp"
#include "kinetrace/hal/fault_injector.hpp"
#include "kinetrace/hal/file_stereo_camera.hpp"
#include "kinetrace/hal/frame_guard.hpp"
#include "kinetrace/hal/live_stereo_camera.hpp"

namespace kinetrace::app {

/// A camera behind its guard, with a look past the guard for reports.
struct GuardedCamera {
  std::unique_ptr<hal::FrameGuard> camera;
  const hal::FileStereoCamera* file = nullptr;  ///< Null for live cameras.
  hal::LiveStereoCamera* live = nullptr;        ///< Null for recordings.
};

struct CameraSetup {
  hal::RigCalibration calibration;
  std::optional<hal::Dataset> dataset;        ///< A recording ...
  std::optional<hal::LiveCameraConfig> live;  ///< ... or devices.
  std::filesystem::path folder;               ///< The recording's; empty for devices.
  int passes = 1;
  hal::FaultPlan faults;
  /// Named by --camera, or a recording that faults make one: waited for when lost, and its pairs are watched. A
  /// recording that has gone ends the run.
  bool is_camera = false;
  bool mends_times = true;  ///< Of a camera, see FrameGuardConfig; not where its times are what is looked at.
  std::string images;       ///< Where they come from, in words: "recording kitti-raw:out/town".
  std::vector<std::pair<std::string, std::string>> description;  ///< For run.json.
  std::vector<std::string> notes;

  /// As the recording or the camera file says.
  [[nodiscard]] double rate_hz() const { return live ? live->left.rate_hz : dataset->nominal_rate_hz; }
  [[nodiscard]] std::size_t required_bytes() const;
  /// Errors: kCapacity, kUnsupported, kInvalidArgument.
  [[nodiscard]] Result<GuardedCamera> make(Arena& arena) const;
};

/// From --dataset or --camera, and --fault.
[[nodiscard]] Outcome<CameraSetup> camera_setup(const SourceOptions& options);
/// A recording as it is.
[[nodiscard]] CameraSetup recording_setup(const hal::Dataset& dataset);

}  // namespace kinetrace::app
