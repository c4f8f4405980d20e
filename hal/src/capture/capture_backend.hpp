// How a backend outside this library joins it. Explicit: the application says so before it opens a camera.
#pragma once

#include <functional>
#include <memory>
#include <vector>

#include "capture/capture_device.hpp"

namespace kinetrace::hal {

struct CaptureBackendEntry {
  std::function<std::unique_ptr<CaptureDevice>(const CaptureConfig& config)> make;
  std::function<std::vector<CaptureListing>()> list;
};

/// From then on make_capture_device and list_capture_devices know the backend. Not while other threads use them.
void register_capture_backend(CaptureBackend backend, const CaptureBackendEntry& entry);

}  // namespace kinetrace::hal
