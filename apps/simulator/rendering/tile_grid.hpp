// Comparison of a tile's pixels with their neighbours.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>

#include "rendering/tile.hpp"

namespace kinetrace::simulator {

/// A value for each pixel of a tile, with a margin for pixels outside the tile or the picture. Neighbours are pixels
/// that share a side.
class TileGrid {
 public:
  static constexpr std::uint32_t kOutside = ~0U;

  void clear() noexcept { values_.fill(kOutside); }
  /// `value` is not kOutside.
  void set(std::size_t slot, std::uint32_t value) noexcept { values_[kPlace[slot]] = value; }
  [[nodiscard]] std::uint32_t at(std::size_t slot) const noexcept { return values_[kPlace[slot]]; }

  /// Compares all values with those of their neighbours.
  void compare() noexcept {
    const auto same = [this](std::size_t here, std::size_t there) -> std::uint32_t {
      return static_cast<std::uint32_t>(values_[there] == values_[here]) |
             static_cast<std::uint32_t>(values_[there] == kOutside);
    };
    // All at once, margins included: without branches the loop is vectorised.
    for (std::size_t i = kSide; i < kSize - kSide; ++i) {
      steady_[i] = same(i, i - 1) & same(i, i + 1) & same(i, i - kSide) & same(i, i + kSide);
    }
  }
  /// Whether all neighbours had the same value in compare().
  [[nodiscard]] bool is_steady(std::size_t slot) const noexcept { return steady_[kPlace[slot]] != 0U; }

  /// Whether `agrees` holds for this slot and those of its neighbours.
  template <typename Agrees>
  [[nodiscard]] bool agree_around(std::size_t slot, const Agrees& agrees) const {
    const std::size_t here = kPlace[slot];
    const std::array<std::size_t, 5> places{here, here - 1, here + 1, here - kSide, here + kSide};
    return std::all_of(places.begin(), places.end(),
                       [&](std::size_t place) { return values_[place] == kOutside || agrees(kSlot[place]); });
  }

 private:
  static constexpr std::size_t kSide = kTileSide_px + 2;
  static constexpr std::size_t kSize = kSide * kSide;

  // Index of each slot in the row-major grid, and the inverse.
  static constexpr std::array<std::size_t, kTilePixels> kPlace = [] {
    std::array<std::size_t, kTilePixels> places{};
    for (std::size_t slot = 0; slot < kTilePixels; ++slot) {
      const auto& [x, y] = kTileOrder[slot];
      places[slot] = static_cast<std::size_t>(y + 1) * kSide + static_cast<std::size_t>(x + 1);
    }
    return places;
  }();
  static constexpr std::array<std::size_t, kSize> kSlot = [] {
    std::array<std::size_t, kSize> slots{};
    for (std::size_t slot = 0; slot < kTilePixels; ++slot) {
      slots[kPlace[slot]] = slot;
    }
    return slots;
  }();

  std::array<std::uint32_t, kSize> values_{};
  std::array<std::uint32_t, kSize> steady_{};
};

}  // namespace kinetrace::simulator
