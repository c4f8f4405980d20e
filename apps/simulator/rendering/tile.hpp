// Small squares of pixels that are traced together.
#pragma once

#include <array>
#include <cstddef>

namespace kinetrace::simulator {

inline constexpr int kTileSide_px = 16;
inline constexpr std::size_t kTilePixels = std::size_t{kTileSide_px} * kTileSide_px;

/// The tile's pixels (x, y), relative to its corner, in the order in which they are traced: along Morton's curve, so
/// that the rays of a packet stay close together. A pixel's index in it is its slot.
inline constexpr std::array<std::array<int, 2>, kTilePixels> kTileOrder = [] {
  std::array<std::array<int, 2>, kTilePixels> order{};
  for (std::size_t slot = 0; slot < kTilePixels; ++slot) {
    for (unsigned bit = 0; (1 << bit) < kTileSide_px; ++bit) {
      order[slot][0] |= static_cast<int>(slot >> (2 * bit) & 1U) << bit;
      order[slot][1] |= static_cast<int>(slot >> (2 * bit + 1) & 1U) << bit;
    }
  }
  return order;
}();

}  // namespace kinetrace::simulator
