// Control of the kernel's test camera: the faults that its driver can inject.
#pragma once

#include <string>

#include "kinetrace/hal/live_camera_config.hpp"

namespace kinetrace::hal::test {

/// The guest's two cameras. They have the same modes; the second one speaks the multi-planar interface.
inline const std::string kVividLeft = "platform:vivid-000";
inline const std::string kVividRight = "platform:vivid-001";

/// A mode of both cameras, small enough for an emulated processor.
[[nodiscard]] CaptureConfig vivid_config(const std::string& device, PixelFormat format = PixelFormat::kGrey8);

/// A control of a vivid device by its name, as `v4l2-ctl --list-ctrls` prints it; buttons take 1. Controls are set back
/// to their defaults on destruction.
class VividControls {
 public:
  explicit VividControls(const std::string& device);
  VividControls(const VividControls&) = delete;
  VividControls& operator=(const VividControls&) = delete;
  ~VividControls();

  /// Throws std::runtime_error if there is no such control or the driver refuses.
  void set(const std::string& name, int value) const;

 private:
  template <typename Visit>
  void visit(Visit&& visitor) const;
  int fd_ = -1;
};

}  // namespace kinetrace::hal::test
