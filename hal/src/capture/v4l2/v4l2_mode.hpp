// Format, size and rate of a V4L2 device.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "capture/capture_device.hpp"
#include "capture/v4l2/v4l2_file.hpp"
#include "capture/v4l2/v4l2_node.hpp"
#include "kinetrace/core/result.hpp"
#include "kinetrace/hal/live_camera_config.hpp"

namespace kinetrace::hal {

/// The buffer type of all calls on this node.
[[nodiscard]] std::uint32_t v4l2_buffer_type(const V4l2Node& node) noexcept;

/// Sets format, size and rate, and writes the values of the driver, with the stride, to `info`. Errors: kUnsupported
/// (the driver set another value; prints both and the supported ones), kIo, kDisconnected.
[[nodiscard]] Status set_v4l2_mode(const V4l2File& file, const V4l2Node& node, const CaptureConfig& config,
                                   CaptureInfo& info);

/// The modes that Kinetrace can use: "grey8 640x480 at 15, 30, 60 Hz".
[[nodiscard]] std::vector<std::string> list_v4l2_modes(const V4l2File& file, const V4l2Node& node);

}  // namespace kinetrace::hal
