#include "capture/capture_device.hpp"

#include <array>
#include <utility>

#include "capture/capture_backend.hpp"
#include "capture/v4l2/v4l2_device.hpp"

namespace kinetrace::hal {
namespace {

std::array<CaptureBackendEntry, 2>& entries() {
  static std::array<CaptureBackendEntry, 2> table{{{&make_v4l2_device, &list_v4l2_devices}, {}}};
  return table;
}

CaptureBackendEntry& entry_of(CaptureBackend backend) {
  return entries()[static_cast<std::size_t>(backend)];
}

}  // namespace

void register_capture_backend(CaptureBackend backend, const CaptureBackendEntry& entry) {
  entry_of(backend) = entry;
}

Result<std::unique_ptr<CaptureDevice>> make_capture_device(const CaptureConfig& config) {
  const CaptureBackendEntry& entry = entry_of(config.backend);
  if (!entry.make) {
    return fail(ErrorCode::kUnsupported, config.device +
                                             ": this build knows nothing of libcamera; build it with "
                                             "KINETRACE_WITH_LIBCAMERA=ON where libcamera is installed");
  }
  return entry.make(config);
}

std::vector<CaptureListing> list_capture_devices() {
  std::vector<CaptureListing> all;
  for (const CaptureBackendEntry& entry : entries()) {
    if (entry.list) {
      for (CaptureListing& listing : entry.list()) {
        all.push_back(std::move(listing));
      }
    }
  }
  return all;
}

}  // namespace kinetrace::hal
