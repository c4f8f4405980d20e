// Which capture devices this machine has.
#pragma once

#include <string>
#include <vector>

#include "kinetrace/core/export.hpp"
#include "kinetrace/hal/live_camera_config.hpp"

namespace kinetrace::hal {

/// What `kinetrace doctor` shows of a device.
struct CaptureListing {
  CaptureBackend backend = CaptureBackend::kV4l2;
  std::string path;  ///< Empty where the backend has none.
  std::string stable_id;
  std::string name;
  std::string problem{};           ///< Why nothing more is known of it, and what to do; empty: all is known.
  std::vector<std::string> modes;  ///< "GREY 640x480 at 5..60 Hz"
};

/// Every capture device of this machine, of all backends built in. None is no error.
[[nodiscard]] KINETRACE_API std::vector<CaptureListing> list_capture_devices();

}  // namespace kinetrace::hal
