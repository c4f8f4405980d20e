// Exposure, gain and trigger of a V4L2 device.
#pragma once

#include <optional>

#include "capture/capture_device.hpp"
#include "capture/v4l2/v4l2_file.hpp"
#include "kinetrace/core/result.hpp"
#include "kinetrace/hal/live_camera_config.hpp"

namespace kinetrace::hal {

/// Sets the configured values, leaves the others to the device's automatic control if it has one, and writes exposure
/// and gain as read back to `info`. Errors: kUnsupported (no such control, or another value set; prints both), kIo,
/// kDisconnected.
[[nodiscard]] Status set_v4l2_controls(const V4l2File& file, const CaptureConfig& config, CaptureInfo& info);

/// The current exposure, automatic ones included; none if the device does not report it.
[[nodiscard]] std::optional<double> read_v4l2_exposure_us(const V4l2File& file) noexcept;

}  // namespace kinetrace::hal
