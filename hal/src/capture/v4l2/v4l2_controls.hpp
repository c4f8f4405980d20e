// Exposure, gain and trigger of a V4L2 device.
#pragma once

#include <optional>

#include "capture/capture_device.hpp"
#include "capture/v4l2/v4l2_file.hpp"
#include "kinetrace/core/result.hpp"
#include "kinetrace/hal/live_camera_config.hpp"

namespace kinetrace::hal {

/// Sets what the configuration names, leaves the rest to the device's automatics where it has any, and fills exposure
/// and gain into `info` as read back. Errors: kUnsupported (no such control, or
/// set to something else: both are printed), kIo, kDisconnected.
[[nodiscard]] Status set_v4l2_controls(const V4l2File& file, const CaptureConfig& config, CaptureInfo& info);

/// The exposure that the device uses now, also where it chooses that itself; none where it does not tell.
[[nodiscard]] std::optional<double> read_v4l2_exposure_us(const V4l2File& file) noexcept;

}  // namespace kinetrace::hal
