#include "capture/v4l2/v4l2_device.hpp"

#include <algorithm>
#include <cerrno>
#include <limits>
#include <linux/videodev2.h>
#include <optional>
#include <string>
#include <utility>

#include "capture/frame_wait.hpp"
#include "capture/image_layout.hpp"
#include "capture/v4l2/v4l2_controls.hpp"
#include "capture/v4l2/v4l2_mode.hpp"
#include "capture/v4l2/v4l2_node.hpp"
#include "capture/v4l2/v4l2_queue.hpp"
#include "synchronization/sequence_unwrapper.hpp"
#include "util/messages.hpp"

namespace kinetrace::hal {
namespace {

// A bus id shared by several nodes identifies none of them.
std::string stable_id(const V4l2Node& node, const std::vector<V4l2Node>& nodes) {
  const auto sharing =
      std::count_if(nodes.begin(), nodes.end(), [&node](const V4l2Node& other) { return other.bus_id == node.bus_id; });
  return node.bus_id.empty() || sharing > 1 ? node.path : node.bus_id;
}

class V4l2Device final : public CaptureDevice {
 public:
  explicit V4l2Device(const CaptureConfig& config) : config_(config) {}
  ~V4l2Device() override { close(); }

  Status open() override;
  Status start() override;
  Result<CapturedImage> next(std::chrono::milliseconds timeout) override;
  void release(int slot) noexcept override {
    if (stream_) {
      stream_->queue.release(stream_->file, slot);
    }
  }
  Status stop() override;
  void close() noexcept override { stream_.reset(); }
  int wait_fd() const noexcept override { return stream_ ? stream_->file.fd() : -1; }
  const CaptureInfo& info() const noexcept override { return info_; }

 private:
  // The queue is unmapped before the file is closed.
  struct Stream {
    V4l2File file;
    V4l2Queue queue;
  };

  [[nodiscard]] Status read_timestamp_kind(const V4l2Queue& queue);
  [[nodiscard]] Status require_open() const;
  [[nodiscard]] std::optional<std::int64_t> exposure_ns() noexcept;

  CaptureConfig config_;
  CaptureInfo info_;
  std::optional<Stream> stream_;
  SequenceUnwrapper sequence_;
  std::optional<double> exposure_us_;  ///< As last read.
  int until_exposure_is_read_ = 0;     ///< Images.
};

Status V4l2Device::open() {
  const auto node = find_v4l2_node(config_.device);
  if (!node) {
    return Unexpected(node.error());
  }
  auto file = V4l2File::open(node->path);
  if (!file) {
    return Unexpected(file.error());
  }
  info_ = {};
  info_.name = node->described();
  info_.stable_id = stable_id(*node, list_v4l2_nodes());
  info_.serial = node->serial;
  // The driver of USB cameras counts delivered images, not those of the sensor.
  info_.sequence_counts_losses = node->driver != "uvcvideo";
  if (Status set = set_v4l2_mode(*file, *node, config_, info_); !set) {
    return set;
  }
  if (Status set = set_v4l2_controls(*file, config_, info_); !set) {
    return set;
  }
  auto queue = V4l2Queue::create(*file, v4l2_buffer_type(*node), config_.buffers);
  if (!queue) {
    return Unexpected(queue.error());
  }
  if (Status known = read_timestamp_kind(*queue); !known) {
    return known;
  }
  stream_.emplace(Stream{std::move(*file), std::move(*queue)});
  return {};
}

Status V4l2Device::read_timestamp_kind(const V4l2Queue& queue) {
  if ((queue.flags() & V4L2_BUF_FLAG_TIMESTAMP_MASK) != V4L2_BUF_FLAG_TIMESTAMP_MONOTONIC) {
    return fail(
        ErrorCode::kUnsupported,
        info_.name + ": its driver does not stamp images in the monotonic clock; they cannot be paired by time");
  }
  info_.timestamp_kind = (queue.flags() & V4L2_BUF_FLAG_TSTAMP_SRC_MASK) == V4L2_BUF_FLAG_TSTAMP_SRC_SOE
                             ? TimestampKind::kStartOfExposure
                             : TimestampKind::kEndOfExposure;
  return {};
}

Status V4l2Device::require_open() const {
  if (!stream_) {
    return fail(ErrorCode::kIllegalState, config_.device + ": is not open");
  }
  return {};
}

Status V4l2Device::start() {
  if (Status opened = require_open(); !opened) {
    return opened;
  }
  sequence_.reset();
  until_exposure_is_read_ = 0;
  return stream_->queue.start(stream_->file);
}

Status V4l2Device::stop() {
  if (Status opened = require_open(); !opened) {
    return opened;
  }
  return stream_->queue.stop(stream_->file);
}

// Not read for every image: automatic exposure changes slowly, and a query of a USB camera costs a transfer.
std::optional<std::int64_t> V4l2Device::exposure_ns() noexcept {
  constexpr int kImagesPerReading = 16;
  constexpr double kNanosecondsPerUs = 1e3;
  if (until_exposure_is_read_-- <= 0) {
    exposure_us_ = info_.exposure_us ? info_.exposure_us : read_v4l2_exposure_us(stream_->file);
    until_exposure_is_read_ = exposure_us_ ? kImagesPerReading - 1 : std::numeric_limits<int>::max();
  }
  return exposure_us_ ? std::optional(static_cast<std::int64_t>(*exposure_us_ * kNanosecondsPerUs)) : std::nullopt;
}

Result<CapturedImage> V4l2Device::next(std::chrono::milliseconds timeout) {
  if (const Status opened = require_open(); !opened) {
    return Unexpected(opened.error());
  }
  stream_->queue.retry_returns(stream_->file);
  V4l2Frame frame;
  const bool ready = wait_readable(stream_->file.fd(), timeout);
  const int code = ready ? stream_->queue.dequeue(stream_->file, frame) : EAGAIN;
  if (code == EAGAIN) {
    return fail(ErrorCode::kTimeout, "no image");  // Frequent: short enough for no allocation.
  }
  if (code != 0) {
    return Unexpected(stream_->file.error(code, "taking an image"));
  }
  return CapturedImage{.slot = frame.slot,
                       .sequence = sequence_.unwrap(frame.sequence),
                       .timestamp_ns = frame.timestamp_ns,
                       .damaged = frame.flagged_damaged || frame.data.size() < bytes_needed(info_),
                       .data = frame.data,
                       .exposure_ns = exposure_ns(),
                       .dmabuf_fd = frame.dmabuf_fd};
}

}  // namespace

std::unique_ptr<CaptureDevice> make_v4l2_device(const CaptureConfig& config) {
  return std::make_unique<V4l2Device>(config);
}

std::vector<CaptureListing> list_v4l2_devices() {
  std::vector<CaptureListing> listings;
  const std::vector<V4l2Node> nodes = list_v4l2_nodes();
  for (const V4l2Node& node : nodes) {
    const auto file = V4l2File::open(node.path);
    listings.push_back({.backend = CaptureBackend::kV4l2,
                        .path = node.path,
                        .stable_id = stable_id(node, nodes),
                        .name = node.card,
                        .modes = file ? list_v4l2_modes(*file, node) : std::vector<std::string>{}});
  }
  for (Error& problem : unreadable_v4l2_nodes()) {
    CaptureListing unreadable;
    unreadable.problem = std::move(problem.message);
    listings.push_back(std::move(unreadable));
  }
  return listings;
}

}  // namespace kinetrace::hal
