// Lists V4L2 devices and finds one by name.
#pragma once

#include <string>
#include <vector>

#include "capture/v4l2/v4l2_file.hpp"
#include "kinetrace/core/result.hpp"

namespace kinetrace::hal {

/// A device file that captures video.
struct V4l2Node {
  std::string path;    ///< Changes when the device is plugged in again.
  std::string bus_id;  ///< Of the socket it is plugged into.
  std::string serial;  ///< Of the USB device; empty where there is none.
  std::string card;
  std::string driver;
  bool multi_planar = false;

  /// For messages: "Stereo Left (usb-0000:00:14.0-3)".
  [[nodiscard]] std::string described() const;
};

/// Every node that captures and streams video, by number. Nodes for metadata or output are left out.
[[nodiscard]] std::vector<V4l2Node> list_v4l2_nodes();

/// Remediable reasons why device files in `folder` cannot be opened: permission, in use.
[[nodiscard]] std::vector<Error> unreadable_v4l2_nodes(const std::string& folder = "/dev");

/// Describes an open file. Errors: kUnsupported (does not capture video), kIo.
[[nodiscard]] Result<V4l2Node> describe_v4l2_node(const V4l2File& file);

/// The node of that path, bus id or serial. Errors: kNotFound (lists the devices), kInvalidArgument (several match).
[[nodiscard]] Result<V4l2Node> find_v4l2_node(const std::string& name);

}  // namespace kinetrace::hal
