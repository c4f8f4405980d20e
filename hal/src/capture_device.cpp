#include "capture_device.hpp"

namespace kinetrace::hal {

Result<std::unique_ptr<CaptureDevice>> make_capture_device(const CaptureConfig& config) {
  return fail(ErrorCode::kUnsupported, config.device + ": this build has no capture backend");
}

std::vector<CaptureListing> list_capture_devices() {
  return {};
}

}  // namespace kinetrace::hal
