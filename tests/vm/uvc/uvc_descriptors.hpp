// Descriptors of the simulated camera: USB 2.0 chapter 9 and the USB Video Class 1.1, chapter 3.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

namespace kinetrace::hal::test {

using Bytes = std::vector<std::uint8_t>;

enum class UvcFormat : std::uint8_t { kYuyv = 1, kGrey8 = 2, kMjpeg = 3 };  ///< bFormatIndex.

struct UvcMode {
  UvcFormat format = UvcFormat::kYuyv;
  int frame = 1;  ///< bFrameIndex within the format.
  int width = 0;
  int height = 0;
  [[nodiscard]] std::uint32_t frame_bytes() const;  ///< At most, where compressed.
};

/// 640 pixels wide and 240 high: both cameras of 320x240 side by side.
inline constexpr std::array<std::array<int, 2>, 3> kUvcSizes{{{320, 240}, {640, 240}, {640, 480}}};
/// In units of 100 ns: 30, 15, 5 Hz.
inline constexpr std::array<std::uint32_t, 3> kUvcIntervals{333'333, 666'666, 2'000'000};
inline constexpr std::uint32_t kUvcDefaultInterval = 2'000'000;  ///< libcamera keeps the default.
inline constexpr std::uint32_t kUvcClock_hz = 1'000'000;

inline constexpr std::uint8_t kCameraTerminal = 1;
inline constexpr std::uint8_t kProcessingUnit = 2;
inline constexpr std::uint8_t kVideoEndpoint = 0x81;

/// The mode of these indices, or the first.
[[nodiscard]] UvcMode find_mode(int format_index, int frame_index);

[[nodiscard]] Bytes device_descriptor();
[[nodiscard]] Bytes configuration_descriptor();
[[nodiscard]] Bytes qualifier_descriptor();
/// Index 0: the languages; 1 maker, 2 product, 3 serial number.
[[nodiscard]] Bytes string_descriptor(int index, const std::string& product, const std::string& serial);

}  // namespace kinetrace::hal::test
