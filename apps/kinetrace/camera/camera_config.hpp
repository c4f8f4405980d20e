// The camera file: devices or files, and their time-outs.
#pragma once

#include <filesystem>
#include <string>
#include <string_view>

#include "kinetrace/core/result.hpp"
#include "kinetrace/hal/dataset.hpp"
#include "kinetrace/hal/live_camera_config.hpp"

namespace kinetrace::app {

enum class CameraKind : std::uint8_t { kV4l2, kLibcamera, kFiles };

[[nodiscard]] std::string_view to_string(CameraKind kind) noexcept;
bool from_string(std::string_view text, CameraKind& kind) noexcept;

/// As written in the file; see config/cameras for commented examples.
struct CameraConfig {
  static constexpr double kNotGiven = -1.0;

  CameraKind source = CameraKind::kV4l2;
  std::string calibration;
  std::string faults;

  std::string left_device;
  std::string right_device;  ///< Empty: the left device delivers both views.
  hal::CaptureConfig image;  ///< Settings of both devices, except the name.
  bool auto_exposure = true;
  double exposure_us = kNotGiven;
  bool auto_gain = true;
  double gain = kNotGiven;
  hal::LiveCameraConfig timeouts;  ///< Pairing and time-outs.

  std::string layout = "folder";
  std::string path;
  std::string sequence;
  int loop = 1;

  /// The devices; `source` is not kFiles.
  [[nodiscard]] hal::LiveCameraConfig live() const;
  /// The recording; `source` is kFiles. Errors: kInvalidConfig.
  [[nodiscard]] Result<hal::DatasetSpec> dataset() const;
};

template <typename Visitor>
void visit_fields(CameraConfig& config, Visitor&& visit) {
  visit("source", config.source, "v4l2, libcamera or files");
  visit("calibration", config.calibration,
        "calibration file of the rig, relative to this file; datasets (source files) have their own");
  visit("faults", config.faults, "faults to inject, for tests; as run --fault");
  visit("devices.left", config.left_device, "left device: path, bus id, serial number or libcamera's id");
  visit("devices.right", config.right_device,
        "right device, likewise; empty where the left one delivers both views side by side");
  visit("image.format", config.image.format, "grey8, grey10, grey16, yuyv, nv12 or mjpeg");
  visit("image.width_px", config.image.width_px,
        "width of an image as a device delivers it, px: both views together where it has both");
  visit("image.height_px", config.image.height_px, "height of an image, px");
  visit("image.rate_hz", config.image.rate_hz, "frame rate, Hz");
  visit("image.auto_exposure", config.auto_exposure, "exposure time chosen by the device");
  visit("image.exposure_us", config.exposure_us, "exposure time without auto_exposure, microseconds");
  visit("image.auto_gain", config.auto_gain, "gain chosen by the device");
  visit("image.gain", config.gain, "gain without auto_gain, in the device's own unit");
  visit("image.trigger", config.image.trigger, "free_running or external");
  visit("image.buffers", config.image.buffers, "image buffers asked of the driver, at least 5");
  visit("pairing.tolerance_ms", config.timeouts.pair_tolerance_ms,
        "maximum difference of the views' mid-exposure times after the learnt offset, ms; at most half a period");
  visit("timeouts.stall_ms", config.timeouts.stall_timeout_ms,
        "time without a pair, exposure on top, after which the camera is stalled, ms");
  visit("timeouts.lost_ms", config.timeouts.lost_timeout_ms,
        "time stalled after which the camera is lost, closed and looked for again, ms");
  visit("timeouts.reopen_first_ms", config.timeouts.reopen_first_ms,
        "first pause between attempts to open the camera, ms; it doubles each time");
  visit("timeouts.reopen_longest_ms", config.timeouts.reopen_longest_ms, "longest pause between attempts, ms");
  visit("files.layout", config.layout,
        "kitti-raw, kitti-odometry, kitti-tracking, euroc, cityscapes, folder or container");
  visit("files.path", config.path, "path of the dataset, relative to this file");
  visit("files.sequence", config.sequence, "sequence, where the path holds several");
  visit("files.loop", config.loop, "number of times that the recording is played");
}

/// Reads and checks a camera file; paths in it become relative to the working directory. The calibration may be missing
/// without `needs_calibration`. Errors, with file and line or key: kNotFound, kIo, kInvalidConfig.
[[nodiscard]] Result<CameraConfig> load_camera_config(const std::filesystem::path& path, bool needs_calibration = true);

}  // namespace kinetrace::app
