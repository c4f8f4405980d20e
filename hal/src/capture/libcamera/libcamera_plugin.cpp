// The whole of kinetrace-libcamera.so beside kinetrace::hal_libcamera.
#include "capture/capture_plugin.hpp"
#include "capture/isolated/isolated_backend.hpp"
#include "capture/libcamera/libcamera_device.hpp"

extern "C" [[gnu::visibility("default")]] void kinetrace_capture_plugin(kinetrace::hal::RegisterCaptureBackend add) {
  using namespace kinetrace::hal;
  add(CaptureBackend::kLibcamera, isolate({&make_libcamera_device, &list_libcamera_devices}, "libcamera"));
}
