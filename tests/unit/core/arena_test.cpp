#include "kinetrace/core/arena.hpp"

#include <cstdint>
#include <limits>

#include <gtest/gtest.h>

namespace kinetrace {
namespace {

struct Pose {
  double values[12] = {1.0};
};

struct Storage {
  std::span<std::uint8_t> bytes;
  std::span<Pose> poses;
  std::span<float> floats;
};

Storage carve(Arena& arena, std::size_t n) {
  return {arena.take<std::uint8_t>(n), arena.take<Pose>(n), arena.take<float>(3 * n)};
}

TEST(Arena, MeasuringHandsOutNothingAndCountsWhatTheRealOneTakes) {
  for (const std::size_t n : {0, 1, 7, 64, 65}) {
    Arena measuring;
    const Storage empty = carve(measuring, n);
    EXPECT_TRUE(measuring.measuring());
    EXPECT_TRUE(empty.bytes.empty() && empty.poses.empty() && empty.floats.empty());
    EXPECT_FALSE(measuring.exhausted());

    Arena real(measuring.used_bytes());
    const Storage storage = carve(real, n);
    EXPECT_FALSE(real.exhausted());
    EXPECT_EQ(real.used_bytes(), measuring.used_bytes());
    EXPECT_EQ(storage.bytes.size(), n);
    EXPECT_EQ(storage.poses.size(), n);
    EXPECT_EQ(storage.floats.size(), 3 * n);
  }
}

TEST(Arena, MeasureBytesRunsTheCarvingFunction) {
  EXPECT_EQ(measure_bytes([](Arena& arena) { carve(arena, 1); }), 64U + 128U + 64U);
}

TEST(Arena, AlignsAndInitialisesEveryPiece) {
  Arena arena(4096);
  const Storage storage = carve(arena, 3);
  for (const auto address :
       {reinterpret_cast<std::uintptr_t>(storage.bytes.data()), reinterpret_cast<std::uintptr_t>(storage.poses.data()),
        reinterpret_cast<std::uintptr_t>(storage.floats.data())}) {
    EXPECT_EQ(address % Arena::kAlignment, 0U);
  }
  EXPECT_EQ(storage.poses[2].values[0], 1.0);
  EXPECT_EQ(storage.floats[8], 0.F);
}

TEST(Arena, PiecesDoNotOverlap) {
  Arena arena(4096);
  const auto first = arena.take<std::uint8_t>(100);
  const auto second = arena.take<std::uint8_t>(100);
  EXPECT_GE(second.data(), first.data() + first.size());
}

TEST(Arena, HoldsExactlyItsCapacityAndReportsOneByteMore) {
  Arena arena(128);
  EXPECT_EQ(arena.take<std::uint8_t>(128).size(), 128U);
  EXPECT_FALSE(arena.exhausted());
  EXPECT_TRUE(arena.take<std::uint8_t>(1).empty());
  EXPECT_TRUE(arena.exhausted());
  EXPECT_EQ(arena.used_bytes(), 128U);
}

TEST(Arena, ACountThatOverflowsIsRefusedNotWrappedRound) {
  constexpr std::size_t kHuge = std::numeric_limits<std::size_t>::max();
  Arena arena(1024);
  EXPECT_TRUE(arena.take<double>(kHuge / 4 + 2).empty());  // Times eight, this is 8 modulo 2^64.
  EXPECT_TRUE(arena.exhausted());
  Arena measuring;
  (void)measuring.take<double>(kHuge / 4 + 2);
  (void)measuring.take<double>(8);
  EXPECT_GT(measuring.used_bytes(), kHuge / 2);
}

TEST(Arena, WithoutCapacityHoldsNothingButIsNotMeasuring) {
  Arena arena(0);
  EXPECT_FALSE(arena.measuring());
  EXPECT_TRUE(arena.take<int>(1).empty());
  EXPECT_TRUE(arena.exhausted());
}

}  // namespace
}  // namespace kinetrace
