#include "capture/v4l2/v4l2_queue.hpp"

#include <algorithm>
#include <cerrno>
#include <fcntl.h>
#include <linux/videodev2.h>
#include <string>
#include <utility>

#include "util/messages.hpp"

namespace kinetrace::hal {
namespace {

// A v4l2_buffer with its planes. Not movable: the buffer points to the planes.
class BufferRequest {
 public:
  BufferRequest(std::uint32_t type, std::uint32_t index) noexcept {
    buffer_.type = type;
    buffer_.memory = V4L2_MEMORY_MMAP;
    buffer_.index = index;
    if (multi_planar()) {
      buffer_.m.planes = planes_.data();
      buffer_.length = static_cast<__u32>(planes_.size());
    }
  }
  BufferRequest(const BufferRequest&) = delete;
  BufferRequest& operator=(const BufferRequest&) = delete;

  [[nodiscard]] v4l2_buffer* get() noexcept { return &buffer_; }
  [[nodiscard]] std::size_t length() const noexcept { return multi_planar() ? planes_[0].length : buffer_.length; }
  [[nodiscard]] std::int64_t offset() const noexcept {
    return multi_planar() ? planes_[0].m.mem_offset : buffer_.m.offset;
  }
  [[nodiscard]] std::size_t data_offset() const noexcept { return multi_planar() ? planes_[0].data_offset : 0; }
  [[nodiscard]] std::size_t bytes_used() const noexcept {
    return multi_planar() ? planes_[0].bytesused : buffer_.bytesused;
  }

 private:
  [[nodiscard]] bool multi_planar() const noexcept { return buffer_.type == V4L2_BUF_TYPE_VIDEO_CAPTURE_MPLANE; }

  v4l2_buffer buffer_{};
  std::array<v4l2_plane, VIDEO_MAX_PLANES> planes_{};
};

std::int64_t nanoseconds(const timeval& time) {
  return static_cast<std::int64_t>(time.tv_sec) * 1'000'000'000 + static_cast<std::int64_t>(time.tv_usec) * 1'000;
}

OwnedFd export_buffer(const V4l2File& file, std::uint32_t type, std::uint32_t index) {
  v4l2_exportbuffer request{};
  request.type = type;
  request.index = index;
  request.flags = O_RDONLY | O_CLOEXEC;
  return file.call(VIDIOC_EXPBUF, &request) == 0 ? OwnedFd(request.fd) : OwnedFd();
}

}  // namespace

Result<V4l2Queue> V4l2Queue::create(const V4l2File& file, std::uint32_t type, int count) {
  v4l2_requestbuffers request{};
  request.count = static_cast<__u32>(count);
  request.type = type;
  request.memory = V4L2_MEMORY_MMAP;
  if (const Status granted = file.require(VIDIOC_REQBUFS, &request, "requesting buffers"); !granted) {
    return Unexpected(granted.error());
  }
  if (request.count < static_cast<__u32>(count)) {
    return fail(ErrorCode::kUnsupported,
                concat(file.path(), ": asked for ", std::to_string(count), " buffers, the driver gave ",
                       std::to_string(request.count), "; choose smaller images or fewer buffers"));
  }
  V4l2Queue queue;
  queue.type_ = type;
  queue.buffers_.reserve(request.count);
  for (__u32 index = 0; index < request.count; ++index) {
    if (const Status taken = queue.take(file, index); !taken) {
      return Unexpected(taken.error());
    }
  }
  return queue;
}

Status V4l2Queue::take(const V4l2File& file, std::uint32_t index) {
  BufferRequest request(type_, index);
  if (Status known = file.require(VIDIOC_QUERYBUF, request.get(), "querying a buffer"); !known) {
    return known;
  }
  MappedBytes mapping(file.fd(), request.length(), request.offset());
  if (!mapping.valid()) {
    return Unexpected(file.error(errno, "mapping a buffer"));
  }
  flags_ = request.get()->flags;
  buffers_.push_back({std::move(mapping), export_buffer(file, type_, index), Place::kUser});
  return {};
}

int V4l2Queue::enqueue(const V4l2File& file, std::uint32_t index) noexcept {
  BufferRequest request(type_, index);
  const int code = file.call(VIDIOC_QBUF, request.get());
  buffers_[index].place = code == 0 ? Place::kDriver : Place::kReturning;
  return code;
}

Status V4l2Queue::start(const V4l2File& file) {
  for (std::uint32_t index = 0; index < buffers_.size(); ++index) {
    if (const int code = enqueue(file, index); code != 0) {
      const Status stopped = stop(file);
      return Unexpected(stopped ? file.error(code, "queueing a buffer") : stopped.error());
    }
  }
  if (Status started = file.require(VIDIOC_STREAMON, &type_, "starting the stream"); !started) {
    const Status stopped = stop(file);
    return stopped ? started : stopped;
  }
  streaming_ = true;
  return {};
}

Status V4l2Queue::stop(const V4l2File& file) {
  streaming_ = false;
  for (Buffer& buffer : buffers_) {
    buffer.place = Place::kUser;
  }
  Status stopped = file.require(VIDIOC_STREAMOFF, &type_, "stopping the stream");
  return !stopped && stopped.error().code == ErrorCode::kDisconnected ? Status{} : stopped;
}

void V4l2Queue::retry_returns(const V4l2File& file) noexcept {
  for (std::uint32_t index = 0; index < buffers_.size(); ++index) {
    if (buffers_[index].place == Place::kReturning) {
      enqueue(file, index);
    }
  }
}

int V4l2Queue::dequeue(const V4l2File& file, V4l2Frame& frame) noexcept {
  BufferRequest request(type_, 0);
  if (const int code = file.call(VIDIOC_DQBUF, request.get()); code != 0) {
    return code;
  }
  const v4l2_buffer& filled = *request.get();
  if (filled.index >= buffers_.size()) {
    return EIO;  // Drivers are not trusted.
  }
  Buffer& buffer = buffers_[filled.index];
  buffer.place = Place::kUser;
  const std::span<const std::byte> bytes = buffer.mapping.bytes();
  const std::size_t begin = std::min(request.data_offset(), bytes.size());
  const std::size_t end = std::clamp(request.bytes_used(), begin, bytes.size());
  frame = {.slot = static_cast<int>(filled.index),
           .sequence = filled.sequence,
           .timestamp_ns = nanoseconds(filled.timestamp),
           .flagged_damaged = (filled.flags & V4L2_BUF_FLAG_ERROR) != 0,
           .data = bytes.subspan(begin, end - begin),
           .dmabuf_fd = buffer.dmabuf.valid() ? std::optional(buffer.dmabuf.get()) : std::nullopt};
  return 0;
}

void V4l2Queue::release(const V4l2File& file, int slot) noexcept {
  const auto index = static_cast<std::size_t>(slot);
  if (streaming_ && slot >= 0 && index < buffers_.size() && buffers_[index].place == Place::kUser) {
    enqueue(file, static_cast<std::uint32_t>(index));
  }
}

}  // namespace kinetrace::hal
