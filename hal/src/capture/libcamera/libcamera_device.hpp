// A camera of libcamera as a stream of images.
#pragma once

#include <memory>
#include <vector>

#include "capture/capture_device.hpp"

namespace kinetrace::hal {

[[nodiscard]] std::unique_ptr<CaptureDevice> make_libcamera_device(const CaptureConfig& config);
[[nodiscard]] std::vector<CaptureListing> list_libcamera_devices();

}  // namespace kinetrace::hal
