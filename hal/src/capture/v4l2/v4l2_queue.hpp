// The buffers that a V4L2 driver fills, mapped into this process.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "capture/mapped_bytes.hpp"
#include "capture/v4l2/v4l2_file.hpp"
#include "kinetrace/core/result.hpp"
#include "util/owned_fd.hpp"

namespace kinetrace::hal {

/// A filled buffer.
struct V4l2Frame {
  int slot = -1;
  std::uint32_t sequence = 0;
  std::int64_t timestamp_ns = 0;
  bool flagged_damaged = false;
  std::span<const std::byte> data;  ///< Of the first plane: luminance comes first in every format in use.
  std::optional<int> dmabuf_fd;
};

/// Buffers of one stream. Between start() and stop() each is with the driver, with us, or on its way back.
class V4l2Queue {
 public:
  V4l2Queue() = default;
  V4l2Queue(V4l2Queue&&) noexcept = default;
  V4l2Queue& operator=(V4l2Queue&&) noexcept = default;
  ~V4l2Queue() = default;

  /// Allocates, maps and, if the driver can, exports `count` buffers. Errors: kUnsupported (fewer), kIo, kDisconnected.
  [[nodiscard]] static Result<V4l2Queue> create(const V4l2File& file, std::uint32_t type, int count);

  [[nodiscard]] Status start(const V4l2File& file);
  /// Takes all buffers back from the driver. A device that has gone counts as stopped.
  [[nodiscard]] Status stop(const V4l2File& file);
  /// 0 and the frame, or the errno.
  [[nodiscard]] int dequeue(const V4l2File& file, V4l2Frame& frame) noexcept;
  /// Returns a frame's buffer to the driver; no effect for a slot that is not in use. If the driver refuses, the buffer
  /// waits for retry_returns().
  void release(const V4l2File& file, int slot) noexcept;
  void retry_returns(const V4l2File& file) noexcept;

  [[nodiscard]] std::size_t size() const noexcept { return buffers_.size(); }
  /// V4L2_BUF_FLAG_* of a dequeued buffer: clock and moment of time stamps.
  [[nodiscard]] std::uint32_t flags() const noexcept { return flags_; }

 private:
  enum class Place : std::uint8_t { kDriver, kUser, kReturning };
  struct Buffer {
    MappedBytes mapping;
    OwnedFd dmabuf;
    Place place = Place::kUser;
  };

  [[nodiscard]] Status take(const V4l2File& file, std::uint32_t index);
  int enqueue(const V4l2File& file, std::uint32_t index) noexcept;

  std::uint32_t type_ = 0;
  std::uint32_t flags_ = 0;
  bool streaming_ = false;
  std::vector<Buffer> buffers_;
};

}  // namespace kinetrace::hal
