#include "synchronization/image_numbering.hpp"

#include <gtest/gtest.h>

namespace kinetrace::hal {
namespace {

constexpr std::int64_t kPeriod = 100;

TEST(ImageNumbering, LeavesOutTheNumbersThatTheDriverLeavesOut) {
  ImageNumbering numbering(kPeriod);
  const std::int64_t first = numbering.next(70, 0);
  EXPECT_EQ(numbering.next(71, kPeriod) - first, 1);
  EXPECT_EQ(numbering.next(75, 2 * kPeriod) - first, 5) << "the driver knows better than the clock";
  EXPECT_EQ(numbering.next(76, std::nullopt) - first, 6);
  EXPECT_EQ(numbering.number() - first, 6);
}

TEST(ImageNumbering, NeverStandsStill) {
  ImageNumbering numbering(kPeriod);
  const std::int64_t first = numbering.next(70, 0);
  EXPECT_EQ(numbering.next(70, 1) - first, 1);
  EXPECT_EQ(numbering.next(3, 2) - first, 2);
  EXPECT_EQ(numbering.next(4, 3) - first, 3);
}

TEST(ImageNumbering, CountsPeriodsWhereTheDriverDoesNotCount) {
  ImageNumbering numbering(kPeriod);
  const std::int64_t first = numbering.next(std::nullopt, 1000);
  EXPECT_EQ(numbering.next(std::nullopt, 1000 + 110) - first, 1);
  EXPECT_EQ(numbering.next(std::nullopt, 1000 + 110 + 290) - first, 4);
  EXPECT_EQ(numbering.next(std::nullopt, 1000 + 110 + 291) - first, 5) << "too early, but another image";
}

TEST(ImageNumbering, AnImageWithoutATimeDoesNotMoveThoseThatFollow) {
  ImageNumbering numbering(kPeriod);
  const std::int64_t first = numbering.next(std::nullopt, 0);
  EXPECT_EQ(numbering.next(std::nullopt, std::nullopt) - first, 1);
  EXPECT_EQ(numbering.next(std::nullopt, kPeriod) - first, 1) << "the one before came in addition";
  EXPECT_EQ(numbering.next(std::nullopt, std::nullopt) - first, 2);
  EXPECT_EQ(numbering.next(std::nullopt, 3 * kPeriod) - first, 3) << "the one before stood for an image";
}

TEST(ImageNumbering, AcrossARestartTimeTells) {
  ImageNumbering numbering(kPeriod);
  const std::int64_t first = numbering.next(70, 0);
  numbering.restart();
  EXPECT_EQ(numbering.next(0, 4 * kPeriod) - first, 4);
  EXPECT_EQ(numbering.next(1, 5 * kPeriod) - first, 5);
}

}  // namespace
}  // namespace kinetrace::hal
