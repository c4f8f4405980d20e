#include "rendering/tile_grid.hpp"

#include <gtest/gtest.h>

namespace kinetrace::simulator {
namespace {

// Of the pixel (x, y) of the tile.
std::size_t slot_of(int x, int y) {
  for (std::size_t slot = 0; slot < kTilePixels; ++slot) {
    if (kTileOrder[slot] == std::array{x, y}) {
      return slot;
    }
  }
  ADD_FAILURE() << "no slot for " << x << ' ' << y;
  return 0;
}

TileGrid uniform(std::uint32_t value) {
  TileGrid grid;
  grid.clear();
  for (std::size_t slot = 0; slot < kTilePixels; ++slot) {
    grid.set(slot, value);
  }
  return grid;
}

TEST(TileOrder, HoldsEachPixelOnceAndPacketsCloseTogether) {
  constexpr std::size_t kRun = 16;
  for (int y = 0; y < kTileSide_px; ++y) {
    for (int x = 0; x < kTileSide_px; ++x) {
      const std::size_t first = slot_of(x, y) / kRun * kRun;
      EXPECT_EQ(kTileOrder[first][0] / 4, x / 4);
      EXPECT_EQ(kTileOrder[first][1] / 4, y / 4);
    }
  }
}

TEST(TileGrid, IsSteadyUpToItsEdgesIfAllAreEqual) {
  TileGrid grid = uniform(7);
  grid.compare();
  for (std::size_t slot = 0; slot < kTilePixels; ++slot) {
    EXPECT_TRUE(grid.is_steady(slot)) << slot;
  }
}

TEST(TileGrid, TellsTheNeighboursOfAChange) {
  TileGrid grid = uniform(7);
  grid.set(slot_of(0, 5), 8);
  grid.compare();
  for (std::size_t slot = 0; slot < kTilePixels; ++slot) {
    const auto& [x, y] = kTileOrder[slot];
    const bool beside = x + std::abs(y - 5) <= 1;
    EXPECT_EQ(grid.is_steady(slot), !beside) << x << ' ' << y;
    EXPECT_EQ(grid.agree_around(slot, [&](std::size_t at) { return grid.at(at) == 7; }), !beside) << x << ' ' << y;
  }
}

TEST(TileGrid, VisitsNoTileOutsideThePicture) {
  TileGrid grid;
  grid.clear();
  grid.set(slot_of(3, 3), 1);
  grid.compare();
  EXPECT_TRUE(grid.is_steady(slot_of(3, 3)));
  EXPECT_TRUE(grid.agree_around(slot_of(3, 3), [](std::size_t slot) { return slot == slot_of(3, 3); }));
}

}  // namespace
}  // namespace kinetrace::simulator
