// Camera and frame number, written into the picture, so that pixels prove the pairing.
#pragma once

#include <cstdint>
#include <optional>

#include "kinetrace/core/image_view.hpp"

namespace kinetrace::hal::test {

struct FrameMark {
  std::uint32_t index = 0;  ///< Up to 24 bits.
  int view = 0;             ///< 0 left, 1 right.
  friend bool operator==(const FrameMark&, const FrameMark&) = default;
};

/// Width of a mark; pictures are at least as wide, and 8 pixels high.
inline constexpr int kMarkWidth_px = 320;

/// A row of black and white squares, 8 pixels each, which survives JPEG; below it a gradient that moves with the index,
/// with the maximum `brightness`.
void draw_frame(MutableGrayView image, const FrameMark& mark, int brightness);

/// None where the squares are not those of a mark (they have a checksum).
[[nodiscard]] std::optional<FrameMark> read_mark(GrayView image);

}  // namespace kinetrace::hal::test
