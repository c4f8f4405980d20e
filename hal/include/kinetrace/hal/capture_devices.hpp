// Lists the capture devices of this machine.
#pragma once

#include <string>
#include <vector>

#include "kinetrace/core/export.hpp"
#include "kinetrace/hal/live_camera_config.hpp"

namespace kinetrace::hal {

/// A device as `kinetrace doctor` lists it.
struct CaptureListing {
  CaptureBackend backend = CaptureBackend::kV4l2;
  std::string path;  ///< Empty where the backend has none.
  std::string stable_id;
  std::string name;
  std::string problem{};           ///< Why it could not be queried, and the remedy; empty: it could.
  std::vector<std::string> modes;  ///< "GREY 640x480 at 5..60 Hz"
};

/// All capture devices of this machine, of all available backends. An empty list is not an error.
[[nodiscard]] KINETRACE_API std::vector<CaptureListing> list_capture_devices();

}  // namespace kinetrace::hal
