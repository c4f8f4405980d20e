// The source of a run's frames, determined before memory is allocated.
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

/// A camera behind its guard; `file` and `live` give reports direct access.
struct GuardedCamera {
  std::unique_ptr<hal::FrameGuard> camera;
  const hal::FileStereoCamera* file = nullptr;  ///< Null for live cameras.
  hal::LiveStereoCamera* live = nullptr;        ///< Null for recordings.
};

struct CameraSetup {
  hal::RigCalibration calibration;
  std::optional<hal::Dataset> dataset;        ///< A recording ...
  std::optional<hal::LiveCameraConfig> live;  ///< ... or devices.
  std::filesystem::path folder;               ///< Folder of the recording; empty for devices.
  int passes = 1;
  hal::FaultPlan faults;
  /// True for --camera and for a recording with injected faults: the run waits for a lost camera and monitors the
  /// pairing. A lost recording ends the run.
  bool is_camera = false;
  /// For cameras, see FrameGuardConfig; false where the times themselves are examined.
  bool repairs_timestamps = true;
  std::string images;  ///< Source of the images for messages: "recording kitti-raw:out/town".
  std::vector<std::pair<std::string, std::string>> description;  ///< For run.json.
  std::vector<std::string> notes;

  /// Nominal rate of the recording or the camera file.
  [[nodiscard]] double rate_hz() const { return live ? live->left.rate_hz : dataset->nominal_rate_hz; }
  [[nodiscard]] std::size_t required_bytes() const;
  /// Errors: kCapacity, kUnsupported, kInvalidArgument.
  [[nodiscard]] Result<GuardedCamera> make(Arena& arena) const;
};

/// From --dataset or --camera, and --fault.
[[nodiscard]] Outcome<CameraSetup> camera_setup(const SourceOptions& options);
/// A recording without injected faults.
[[nodiscard]] CameraSetup recording_setup(const hal::Dataset& dataset);

}  // namespace kinetrace::app
