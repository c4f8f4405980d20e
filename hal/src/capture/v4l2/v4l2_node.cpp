#include "capture/v4l2/v4l2_node.hpp"

#include <algorithm>
#include <charconv>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <linux/videodev2.h>
#include <optional>
#include <string_view>
#include <utility>

#include "util/messages.hpp"

namespace kinetrace::hal {
namespace {

namespace fs = std::filesystem;

// Fields of fixed length, zero-terminated unless full.
template <std::size_t kSize>
std::string text(const unsigned char (&field)[kSize]) {
  return {field, std::find(std::begin(field), std::end(field), '\0')};
}

// The node belongs to an interface of the USB device; the folder of the device is its parent.
std::string usb_serial(const std::string& path) {
  std::error_code error;
  const fs::path node = fs::canonical(path, error).filename();
  const fs::path interface = fs::canonical("/sys/class/video4linux" / node / "device", error);
  std::ifstream file(interface.parent_path() / "serial");
  std::string serial;
  std::getline(file, serial);
  return error ? std::string() : serial;
}

std::optional<int> node_number(const std::string& file_name) {
  constexpr std::string_view kPrefix = "video";
  int number = 0;
  const char* end = file_name.data() + file_name.size();
  if (!file_name.starts_with(kPrefix) || std::from_chars(file_name.data() + kPrefix.size(), end, number).ptr != end) {
    return std::nullopt;
  }
  return number;
}

std::vector<std::string> node_paths(const std::string& folder) {
  std::vector<std::pair<int, std::string>> numbered;
  std::error_code error;
  for (const fs::directory_entry& entry : fs::directory_iterator(folder, error)) {
    if (const auto number = node_number(entry.path().filename())) {
      numbered.emplace_back(*number, entry.path());
    }
  }
  std::sort(numbered.begin(), numbered.end());
  std::vector<std::string> paths;
  paths.reserve(numbered.size());
  for (auto& [number, path] : numbered) {
    paths.push_back(std::move(path));
  }
  return paths;
}

std::string choices(const std::vector<V4l2Node>& nodes) {
  std::vector<std::string> names;
  names.reserve(nodes.size());
  for (const V4l2Node& node : nodes) {
    names.push_back(concat(node.path, " = ", node.bus_id, node.serial.empty() ? "" : " = ", node.serial));
  }
  return names.empty() ? "this machine has none" : "there are: " + listed(names);
}

Result<V4l2Node> node_at(const std::string& path) {
  auto file = V4l2File::open(path);
  if (!file) {
    return Unexpected(file.error());
  }
  return describe_v4l2_node(*file);
}

}  // namespace

std::string V4l2Node::described() const {
  return concat(card, " (", bus_id, ")");
}

Result<V4l2Node> describe_v4l2_node(const V4l2File& file) {
  v4l2_capability capability{};
  if (file.call(VIDIOC_QUERYCAP, &capability) != 0) {
    return fail(ErrorCode::kUnsupported, file.path() + ": is not a video device");
  }
  // Of the node itself; `capabilities` would be those of all nodes of the device together.
  const __u32 can =
      (capability.capabilities & V4L2_CAP_DEVICE_CAPS) != 0 ? capability.device_caps : capability.capabilities;
  const bool captures = (can & (V4L2_CAP_VIDEO_CAPTURE | V4L2_CAP_VIDEO_CAPTURE_MPLANE)) != 0;
  if (!captures || (can & V4L2_CAP_STREAMING) == 0) {
    return fail(ErrorCode::kUnsupported,
                file.path() + ": does not capture video; a camera often has a second node for metadata beside it");
  }
  return V4l2Node{.path = file.path(),
                  .bus_id = text(capability.bus_info),
                  .serial = usb_serial(file.path()),
                  .card = text(capability.card),
                  .driver = text(capability.driver),
                  .multi_planar = (can & V4L2_CAP_VIDEO_CAPTURE) == 0};
}

std::vector<V4l2Node> list_v4l2_nodes() {
  std::vector<V4l2Node> nodes;
  for (const std::string& path : node_paths("/dev")) {
    if (auto node = node_at(path)) {
      nodes.push_back(std::move(*node));
    }
  }
  return nodes;
}

std::vector<Error> unreadable_v4l2_nodes(const std::string& folder) {
  std::vector<Error> problems;
  for (const std::string& path : node_paths(folder)) {
    if (auto file = V4l2File::open(path); !file && file.error().code == ErrorCode::kIo) {
      problems.push_back(std::move(file.error()));
    }
  }
  return problems;
}

Result<V4l2Node> find_v4l2_node(const std::string& name) {
  if (name.starts_with('/')) {
    auto node = node_at(name);
    if (!node && node.error().code == ErrorCode::kNotFound) {
      node.error().message += "; " + choices(list_v4l2_nodes());
    }
    return node;
  }
  const std::vector<V4l2Node> nodes = list_v4l2_nodes();
  std::vector<V4l2Node> fitting;
  std::copy_if(nodes.begin(), nodes.end(), std::back_inserter(fitting),
               [&name](const V4l2Node& node) { return node.bus_id == name || node.serial == name; });
  if (fitting.size() == 1) {
    return fitting.front();
  }
  if (fitting.empty()) {
    return fail(ErrorCode::kNotFound,
                concat(name, ": no V4L2 camera has this bus id or serial number; ", choices(nodes)));
  }
  return fail(ErrorCode::kInvalidArgument,
              concat(name, ": several cameras are called so; name one by its path or bus id; ", choices(fitting)));
}

}  // namespace kinetrace::hal
