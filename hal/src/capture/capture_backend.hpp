// Registration of backends outside this library, by the application, before it opens a camera.
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

/// Adds a backend to make_capture_device and list_capture_devices. Not while other threads use these.
void register_capture_backend(CaptureBackend backend, const CaptureBackendEntry& entry);

}  // namespace kinetrace::hal
