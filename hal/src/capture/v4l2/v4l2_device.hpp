// A V4L2 device as a stream of images.
#pragma once

#include <memory>
#include <vector>

#include "capture/capture_device.hpp"

namespace kinetrace::hal {

[[nodiscard]] std::unique_ptr<CaptureDevice> make_v4l2_device(const CaptureConfig& config);
[[nodiscard]] std::vector<CaptureListing> list_v4l2_devices();

}  // namespace kinetrace::hal
