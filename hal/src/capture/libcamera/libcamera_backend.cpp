#include "kinetrace/hal/libcamera_backend.hpp"

#include "capture/capture_backend.hpp"
#include "capture/isolated/isolated_backend.hpp"
#include "capture/libcamera/libcamera_device.hpp"

namespace kinetrace::hal {

void use_libcamera() {
  register_capture_backend(CaptureBackend::kLibcamera,
                           isolate({&make_libcamera_device, &list_libcamera_devices}, "libcamera"));
}

}  // namespace kinetrace::hal
