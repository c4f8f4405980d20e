// Protocol between the two ends of an isolated capture backend.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string_view>
#include <type_traits>
#include <vector>

#include "capture/capture_device.hpp"
#include "capture/isolated/packet_socket.hpp"

namespace kinetrace::hal {

/// Calls, each answered by a status and its result.
enum class IsolatedCall : std::uint8_t { kList, kOpen, kStart, kStop };

/// Upper bound of an answer; the list of all devices must fit.
inline constexpr std::size_t kMaxAnswerBytes = std::size_t{64} * 1024;
/// Maximum number of buffers of a device.
inline constexpr int kMaxSlots = 32;

/// A filled buffer, or the error that ended the stream. The first image of each buffer carries its descriptor.
struct IsolatedEvent {
  std::uint64_t stream = 0;  ///< Number of starts of the stream so far.
  std::int64_t sequence = 0;
  std::int64_t timestamp_ns = 0;
  std::uint64_t offset_bytes = 0;  ///< In the buffer.
  std::uint64_t size_bytes = 0;
  std::int64_t exposure_ns = kUnknownExposure;
  std::int32_t slot = -1;
  ErrorCode error = ErrorCode::kInternal;
  bool is_image = false;
  bool damaged = false;
  std::array<char, 398> message{};  ///< Of the error; ends with a zero, at a multiple of eight bytes.

  static constexpr std::int64_t kUnknownExposure = -1;
};

/// Returns a buffer.
struct IsolatedRelease {
  std::uint64_t stream = 0;
  std::int64_t slot = -1;
};

/// Without padding, whose bytes would be sent uninitialised.
template <typename T>
[[nodiscard]] std::span<const std::byte> packet_of(const T& value) {
  static_assert(std::is_trivially_copyable_v<T> && std::has_unique_object_representations_v<T>);
  return std::as_bytes(std::span(&value, 1));
}

void put(PacketWriter& packet, const CaptureConfig& config);
void put(PacketWriter& packet, const CaptureInfo& info);
void put(PacketWriter& packet, const std::vector<CaptureListing>& listings);
void put(PacketWriter& packet, const Status& status);
[[nodiscard]] CaptureConfig take_config(PacketReader& packet);
[[nodiscard]] CaptureInfo take_info(PacketReader& packet);
[[nodiscard]] std::vector<CaptureListing> take_listings(PacketReader& packet);
[[nodiscard]] Status take_status(PacketReader& packet);

}  // namespace kinetrace::hal
