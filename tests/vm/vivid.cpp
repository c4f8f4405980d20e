#include "vivid.hpp"

#include <fcntl.h>
#include <linux/videodev2.h>
#include <stdexcept>
#include <sys/ioctl.h>
#include <unistd.h>

#include "capture/v4l2/v4l2_node.hpp"

namespace kinetrace::hal::test {

CaptureConfig vivid_config(const std::string& device, PixelFormat format) {
  CaptureConfig config;
  config.device = device;
  config.format = format;
  config.width_px = 320;
  config.height_px = 180;
  config.rate_hz = 30.0;
  return config;
}

VividControls::VividControls(const std::string& device) {
  const auto node = find_v4l2_node(device);
  fd_ = node ? ::open(node->path.c_str(), O_RDWR | O_CLOEXEC) : -1;
  if (fd_ < 0) {
    throw std::runtime_error(device + ": the guest has no such camera");
  }
  // Text over the picture would change with every frame.
  set("OSD Text Mode", 2);
}

template <typename Visit>
void VividControls::visit(Visit&& visitor) const {
  v4l2_query_ext_ctrl control{};
  control.id = V4L2_CTRL_FLAG_NEXT_CTRL;
  while (ioctl(fd_, VIDIOC_QUERY_EXT_CTRL, &control) == 0) {
    visitor(control);
    control.id |= V4L2_CTRL_FLAG_NEXT_CTRL;
  }
}

VividControls::~VividControls() {
  visit([this](const v4l2_query_ext_ctrl& control) {
    constexpr __u32 kFixed = V4L2_CTRL_FLAG_READ_ONLY | V4L2_CTRL_FLAG_WRITE_ONLY | V4L2_CTRL_FLAG_INACTIVE;
    if ((control.flags & kFixed) == 0 && control.type <= V4L2_CTRL_TYPE_MENU) {
      v4l2_control value{control.id, static_cast<__s32>(control.default_value)};
      ioctl(fd_, VIDIOC_S_CTRL, &value);
    }
  });
  ::close(fd_);
}

void VividControls::set(const std::string& name, int value) const {
  __u32 id = 0;
  visit([&](const v4l2_query_ext_ctrl& control) { id = control.name == name ? control.id : id; });
  v4l2_control request{id, value};
  if (id == 0 || ioctl(fd_, VIDIOC_S_CTRL, &request) != 0) {
    throw std::runtime_error("vivid: cannot set '" + name + "'");
  }
}

}  // namespace kinetrace::hal::test
