// libcamera's camera manager, one per process, and the names of its cameras.
#pragma once

#include <libcamera/libcamera.h>
#include <memory>
#include <string>
#include <vector>

#include "kinetrace/core/result.hpp"
#include "kinetrace/hal/live_camera_config.hpp"

namespace kinetrace::hal {

/// Starts the manager on the first call. Errors: kIo.
[[nodiscard]] Result<libcamera::CameraManager*> libcamera_manager();

/// Errors: kNotFound (lists the cameras), kIo.
[[nodiscard]] Result<std::shared_ptr<libcamera::Camera>> find_libcamera(const std::string& id);

/// Model, or id where it has none.
[[nodiscard]] std::string libcamera_name(const libcamera::Camera& camera);

/// Invalid for a format that this version of libcamera does not know.
[[nodiscard]] libcamera::PixelFormat libcamera_format(PixelFormat format);

}  // namespace kinetrace::hal
