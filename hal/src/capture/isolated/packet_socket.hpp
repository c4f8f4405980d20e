// Packets between two processes of one program: plain values and descriptors over a local socket.
#pragma once

#include <algorithm>
#include <array>
#include <chrono>
#include <cstddef>
#include <cstring>
#include <optional>
#include <span>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include "kinetrace/core/result.hpp"
#include "util/owned_fd.hpp"

namespace kinetrace::hal {

/// Concatenated values in native layout: both ends are the same program.
class PacketWriter {
 public:
  template <typename T>
  PacketWriter& put(const T& value) {
    static_assert(std::is_trivially_copyable_v<T>);
    return append(std::as_bytes(std::span(&value, 1)));
  }
  /// An optional has padding, whose bytes would be sent uninitialised.
  template <typename T>
  PacketWriter& put(const std::optional<T>& value) {
    return put(value.has_value()).put(value.value_or(T{}));
  }
  PacketWriter& put(const std::string& text) { return put(text.size()).append(std::as_bytes(std::span(text))); }
  [[nodiscard]] std::span<const std::byte> bytes() const { return bytes_; }

 private:
  PacketWriter& append(std::span<const std::byte> bytes) {
    const std::size_t before = bytes_.size();
    bytes_.resize(before + bytes.size());
    std::copy(bytes.begin(), bytes.end(), bytes_.begin() + static_cast<std::ptrdiff_t>(before));
    return *this;
  }

  std::vector<std::byte> bytes_;
};

/// Reads values in the order of writing. A missing value is empty, and `complete()` is false from then on.
class PacketReader {
 public:
  explicit PacketReader(std::span<const std::byte> bytes) : bytes_(bytes) {}

  template <typename T>
  [[nodiscard]] T take() {
    static_assert(std::is_trivially_copyable_v<T>);
    T value{};
    if (const auto part = next(sizeof value); part.size() == sizeof value) {
      std::memcpy(&value, part.data(), sizeof value);
    }
    return value;
  }
  template <typename T>
  [[nodiscard]] std::optional<T> take_optional() {
    const bool has_value = take<bool>();
    const T value = take<T>();
    return has_value ? std::optional(value) : std::nullopt;
  }
  [[nodiscard]] std::string text() {
    const auto part = next(take<std::size_t>());
    return {reinterpret_cast<const char*>(part.data()), part.size()};
  }
  [[nodiscard]] bool complete() const { return complete_; }

 private:
  std::span<const std::byte> next(std::size_t count) {
    complete_ = complete_ && count <= bytes_.size();
    const auto part = bytes_.first(complete_ ? count : 0);
    bytes_ = bytes_.subspan(part.size());
    return part;
  }

  std::span<const std::byte> bytes_;
  bool complete_ = true;
};

inline constexpr std::size_t kMaxDescriptors = 2;

/// Result of receive().
struct PacketSize {
  std::size_t bytes = 0;  ///< Zero: the other end has gone.
  std::array<OwnedFd, kMaxDescriptors> descriptors;
};

/// One end of a socket that preserves packet boundaries. Never allocates.
class PacketSocket {
 public:
  PacketSocket() = default;
  explicit PacketSocket(OwnedFd socket) noexcept : socket_(std::move(socket)) {}
  /// Two connected ends. Errors: kIo.
  [[nodiscard]] static Result<std::pair<PacketSocket, PacketSocket>> make_pair();

  /// Does not wait; false if the other end has gone or its queue is full.
  [[nodiscard]] bool send(std::span<const std::byte> packet, std::span<const int> descriptors = {}) const noexcept;
  /// None after the timeout. Bytes beyond `room` are lost.
  [[nodiscard]] std::optional<PacketSize> receive(std::span<std::byte> room,
                                                  std::chrono::milliseconds timeout) const noexcept;
  [[nodiscard]] int fd() const noexcept { return socket_.get(); }

 private:
  OwnedFd socket_;
};

}  // namespace kinetrace::hal
