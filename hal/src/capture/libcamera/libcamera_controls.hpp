// Exposure, gain and rate of a libcamera camera.
#pragma once

#include <libcamera/libcamera.h>

#include "capture/capture_device.hpp"
#include "kinetrace/core/result.hpp"
#include "kinetrace/hal/live_camera_config.hpp"

namespace kinetrace::hal {

/// The controls to start the camera with; fills exposure, gain and rate into `info`. libcamera applies controls with
/// the stream: before, unsupported values are found by the camera's limits; afterwards, by the metadata of images.
/// Errors: kUnsupported (no such control, or outside its limits; prints both).
[[nodiscard]] Result<libcamera::ControlList> choose_libcamera_controls(const libcamera::Camera& camera,
                                                                       const CaptureConfig& config, CaptureInfo& info);

}  // namespace kinetrace::hal
