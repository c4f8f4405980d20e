// How a backend outside this library joins it. Explicit: the application says so before it opens a camera.
#pragma once

#include <memory>
#include <vector>

#include "capture_device.hpp"

namespace kinetrace::hal {

struct CaptureBackendEntry {
  std::unique_ptr<CaptureDevice> (*make)(const CaptureConfig& config) = nullptr;
  std::vector<CaptureListing> (*list)() = nullptr;
};

/// From then on make_capture_device and list_capture_devices know the backend. Not while other threads use them.
void register_capture_backend(CaptureBackend backend, const CaptureBackendEntry& entry);

}  // namespace kinetrace::hal
