#include "uvc_descriptors.hpp"

#include <cstddef>
#include <initializer_list>
#include <string_view>

namespace kinetrace::hal::test {
namespace {

constexpr int kYuyvBits = 16;
constexpr int kGreyBits = 8;

void put16(Bytes& bytes, std::size_t value) {
  bytes.push_back(static_cast<std::uint8_t>(value & 0xffU));
  bytes.push_back(static_cast<std::uint8_t>((value >> 8U) & 0xffU));
}
void put32(Bytes& bytes, std::uint32_t value) {
  put16(bytes, value & 0xffffU);
  put16(bytes, value >> 16U);
}
void put(Bytes& bytes, std::initializer_list<std::uint8_t> values) {
  bytes.insert(bytes.end(), values);
}
void append(Bytes& bytes, const Bytes& more) {
  bytes.insert(bytes.end(), more.begin(), more.end());
}
/// Writes the whole length into the 16-bit field at `place`.
void set_total_length(Bytes& bytes, std::size_t place) {
  bytes[place] = static_cast<std::uint8_t>(bytes.size() & 0xffU);
  bytes[place + 1] = static_cast<std::uint8_t>(bytes.size() >> 8U);
}

// Class-specific descriptors of the control interface (UVC 3.7.2): sensor -> processing unit -> USB.
Bytes control_interface() {
  Bytes bytes;
  put(bytes, {13, 0x24, 0x01, 0x10, 0x01, 0, 0});  // Header, version 1.1; total length at 5.
  put32(bytes, kUvcClock_hz);
  put(bytes, {1, 1});  // One streaming interface: number 1.
  // Camera terminal: exposure mode (bit 1) and exposure time (bit 3).
  put(bytes, {18, 0x24, 0x02, kCameraTerminal, 0x01, 0x02, 0, 0, 0, 0, 0, 0, 0, 0, 3, 0x0a, 0, 0});
  // Processing unit fed by the terminal: brightness (bit 0) and gain (bit 9).
  put(bytes, {12, 0x24, 0x05, kProcessingUnit, kCameraTerminal, 0, 0, 2, 0x01, 0x02, 0, 0});
  put(bytes, {9, 0x24, 0x03, 3, 0x01, 0x01, 0, kProcessingUnit, 0});  // Output terminal: USB streaming.
  set_total_length(bytes, 5);
  return bytes;
}

// UVC payload specification "frame descriptor"; the same for uncompressed (subtype 5) and MJPEG (7).
void put_frames(Bytes& bytes, UvcFormat format, std::uint8_t subtype) {
  for (std::size_t i = 0; i < kUvcSizes.size(); ++i) {
    const UvcMode mode = find_mode(static_cast<int>(format), static_cast<int>(i) + 1);
    put(bytes, {static_cast<std::uint8_t>(26 + 4 * kUvcIntervals.size()), 0x24, subtype,
                static_cast<std::uint8_t>(mode.frame), 0});
    put16(bytes, static_cast<std::size_t>(mode.width));
    put16(bytes, static_cast<std::size_t>(mode.height));
    put32(bytes, mode.frame_bytes() * 8 * 5);  // Least and most bits a second.
    put32(bytes, mode.frame_bytes() * 8 * 30);
    put32(bytes, mode.frame_bytes());
    put32(bytes, kUvcDefaultInterval);
    put(bytes, {static_cast<std::uint8_t>(kUvcIntervals.size())});
    for (const std::uint32_t interval : kUvcIntervals) {
      put32(bytes, interval);
    }
  }
  put(bytes, {6, 0x24, 0x0d, 1, 1, 4});  // Colour matching.
}

void put_uncompressed(Bytes& bytes, UvcFormat format, std::string_view code, int bits) {
  put(bytes, {27, 0x24, 0x04, static_cast<std::uint8_t>(format), static_cast<std::uint8_t>(kUvcSizes.size())});
  bytes.insert(bytes.end(), code.begin(), code.end());
  put(bytes, {0, 0, 0x10, 0, 0x80, 0, 0, 0xaa, 0, 0x38, 0x9b, 0x71});  // The rest of the format's GUID.
  put(bytes, {static_cast<std::uint8_t>(bits), 1, 0, 0, 0, 0});
  put_frames(bytes, format, 0x05);
}

Bytes streaming_interface() {
  Bytes bytes;
  put(bytes, {16, 0x24, 0x01, 3, 0, 0, kVideoEndpoint, 0, 3, 0, 0, 0, 1, 0, 0, 0});  // Three formats; length at 4.
  put_uncompressed(bytes, UvcFormat::kYuyv, "YUY2", kYuyvBits);
  put_uncompressed(bytes, UvcFormat::kGrey8, "Y800", kGreyBits);
  put(bytes, {11, 0x24, 0x06, static_cast<std::uint8_t>(UvcFormat::kMjpeg), static_cast<std::uint8_t>(kUvcSizes.size()),
              0, 1, 0, 0, 0, 0});
  put_frames(bytes, UvcFormat::kMjpeg, 0x07);
  set_total_length(bytes, 4);
  return bytes;
}

}  // namespace

std::uint32_t UvcMode::frame_bytes() const {
  const int bits = format == UvcFormat::kYuyv ? kYuyvBits : kGreyBits;
  return static_cast<std::uint32_t>(width * height * bits / 8);
}

UvcMode find_mode(int format_index, int frame_index) {
  const bool known_format = format_index >= 1 && format_index <= 3;
  const bool known_frame = frame_index >= 1 && frame_index <= static_cast<int>(kUvcSizes.size());
  const int frame = known_frame ? frame_index : 1;
  const auto& size = kUvcSizes[static_cast<std::size_t>(frame - 1)];
  return {static_cast<UvcFormat>(known_format ? format_index : 1), frame, size[0], size[1]};
}

Bytes device_descriptor() {
  // USB 2.0, class "by interface association", endpoint 0 of 64 bytes, strings 1 to 3, one configuration.
  return {18, 1, 0x00, 0x02, 0xef, 2, 1, 64, 0x6b, 0x1d, 0x02, 0x01, 0, 1, 1, 2, 3, 1};
}

Bytes configuration_descriptor() {
  constexpr std::size_t kAmple = 1024;
  Bytes bytes;
  bytes.reserve(kAmple);
  put(bytes, {9, 2, 0, 0, 2, 1, 0, 0x80, 50});  // Two interfaces; total length at 2.
  put(bytes, {8, 0x0b, 0, 2, 0x0e, 3, 0, 2});   // Interfaces 0 and 1 are one video function.
  put(bytes, {9, 4, 0, 0, 0, 0x0e, 1, 0, 2});   // Video control.
  append(bytes, control_interface());
  put(bytes, {9, 4, 1, 0, 1, 0x0e, 2, 0, 0});  // Video streaming, one endpoint.
  append(bytes, streaming_interface());
  put(bytes, {7, 5, kVideoEndpoint, 2, 0x00, 0x02, 0});  // Bulk, 512 bytes.
  set_total_length(bytes, 2);
  return bytes;
}

Bytes qualifier_descriptor() {
  return {10, 6, 0, 2, 0xef, 2, 1, 64, 1, 0};
}

Bytes string_descriptor(int index, const std::string& product, const std::string& serial) {
  if (index == 0) {
    return {4, 3, 0x09, 0x04};  // English.
  }
  const std::string text = index == 1 ? "Kinetrace" : index == 2 ? product : serial;
  Bytes bytes{static_cast<std::uint8_t>(2 + 2 * text.size()), 3};
  for (const char letter : text) {
    put16(bytes, static_cast<std::size_t>(letter));
  }
  return bytes;
}

}  // namespace kinetrace::hal::test
