#include "frame_mark.hpp"

namespace kinetrace::hal::test {
namespace {

constexpr int kSquare_px = 8;
constexpr int kIndexBits = 24;
constexpr int kByteBits = 8;
constexpr int kBits = kIndexBits + 2 * kByteBits;
static_assert(kBits * kSquare_px == kMarkWidth_px);
constexpr std::uint64_t kByteMask = 0xff;
constexpr std::uint64_t kIndexMask = 0xffffff;

std::uint64_t checksum(std::uint64_t content) {
  constexpr std::uint64_t kMix = 0x9e3779b97f4a7c15;
  return ((content + 1) * kMix) >> 56U;
}

std::uint64_t encode(const FrameMark& mark) {
  const std::uint64_t content = ((mark.index & kIndexMask) << kByteBits) | static_cast<std::uint64_t>(mark.view);
  return (content << kByteBits) | checksum(content);
}

bool bit(std::uint64_t code, int square) {
  return ((code >> static_cast<unsigned>(kBits - 1 - square)) & 1U) != 0;
}

}  // namespace

void draw_frame(MutableGrayView image, const FrameMark& mark, int brightness) {
  constexpr unsigned kLevels = 256;
  const std::uint64_t code = encode(mark);
  for (int y = 0; y < image.height; ++y) {
    for (int x = 0; x < image.width; ++x) {
      const bool is_mark = y < kSquare_px && x < kMarkWidth_px;
      const unsigned level = (static_cast<unsigned>(x) + mark.index) % kLevels;
      image.at(x, y) = is_mark ? (bit(code, x / kSquare_px) ? 255 : 0)
                               : static_cast<std::uint8_t>(level * static_cast<unsigned>(brightness) / kLevels);
    }
  }
}

std::optional<FrameMark> read_mark(GrayView image) {
  constexpr int kThreshold = 128;
  if (image.width < kMarkWidth_px || image.height < kSquare_px) {
    return std::nullopt;
  }
  std::uint64_t code = 0;
  for (int square = 0; square < kBits; ++square) {
    const bool is_white = image.at(square * kSquare_px + kSquare_px / 2, kSquare_px / 2) >= kThreshold;
    code = (code << 1U) | (is_white ? 1U : 0U);
  }
  const std::uint64_t content = code >> kByteBits;
  if ((code & kByteMask) != checksum(content)) {
    return std::nullopt;
  }
  return FrameMark{static_cast<std::uint32_t>(content >> kByteBits), static_cast<int>(content & kByteMask)};
}

}  // namespace kinetrace::hal::test
