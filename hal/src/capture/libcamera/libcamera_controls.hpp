// Exposure, gain and rate of a libcamera camera.
#pragma once

#include <libcamera/libcamera.h>

#include "capture/capture_device.hpp"
#include "kinetrace/core/result.hpp"
#include "kinetrace/hal/live_camera_config.hpp"

namespace kinetrace::hal {

/// The controls to start the camera with; fills exposure, gain and rate into `info`. libcamera applies controls with
/// the stream: before that, what the camera cannot do is found by its limits; from then on, by what images report.
/// Errors: kUnsupported (no such control, or outside its limits: both are printed).
[[nodiscard]] Result<libcamera::ControlList> choose_libcamera_controls(const libcamera::Camera& camera,
                                                                       const CaptureConfig& config, CaptureInfo& info);

}  // namespace kinetrace::hal
