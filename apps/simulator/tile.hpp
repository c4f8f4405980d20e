// The small squares of pixels in which pictures are traced.
#pragma once

#include <array>
#include <cstddef>

namespace kinetrace::simulator {

inline constexpr int kTileSide_px = 16;
inline constexpr std::size_t kTilePixels = std::size_t{kTileSide_px} * kTileSide_px;

/// Pixels have slots in the order in which they are traced: by squares of two by two, so that the rays of a packet stay
/// close together. x and y count from the tile's corner. The last bit of a distance depends on the rays that share the
/// packet; hence everybody who traces pixel centres does it in this order.
[[nodiscard]] constexpr std::array<int, 2> tile_pixel(std::size_t slot) noexcept {
  const int block = static_cast<int>(slot / 4);
  const int within = static_cast<int>(slot % 4);
  return {2 * (block % (kTileSide_px / 2)) + within % 2, 2 * (block / (kTileSide_px / 2)) + within / 2};
}

[[nodiscard]] constexpr std::size_t tile_slot(int x, int y) noexcept {
  return static_cast<std::size_t>(((y / 2) * (kTileSide_px / 2) + x / 2) * 4 + (y % 2) * 2 + x % 2);
}

}  // namespace kinetrace::simulator
