#include "transport/byte_budget.hpp"

#include <gtest/gtest.h>

namespace kinetrace::publishing {
namespace {

constexpr std::int64_t kSecond_ns = 1'000'000'000;

TEST(ByteBudget, BeginsWithAQuarterOfASecond) {
  ByteBudget budget(400'000, 4096);
  EXPECT_TRUE(budget.take(100'000, Priority::kEssential));
  EXPECT_FALSE(budget.take(1, Priority::kEssential));
}

TEST(ByteBudget, GrowsWithTimeUpToWhatItHolds) {
  ByteBudget budget(400'000, 4096);
  budget.refill(0);
  ASSERT_TRUE(budget.take(100'000, Priority::kEssential));
  budget.refill(kSecond_ns / 10);
  EXPECT_FALSE(budget.take(40'001, Priority::kEssential));
  EXPECT_TRUE(budget.take(40'000, Priority::kEssential));
  budget.refill(100 * kSecond_ns);
  EXPECT_FALSE(budget.take(100'001, Priority::kEssential));
}

TEST(ByteBudget, PointsLeaveHalfForWhatMattersMore) {
  ByteBudget budget(400'000, 4096);
  EXPECT_TRUE(budget.take(50'000, Priority::kPoints));
  EXPECT_FALSE(budget.take(1, Priority::kPoints));
  EXPECT_FALSE(budget.take(12'501, Priority::kDrawings));
  EXPECT_TRUE(budget.take(12'500, Priority::kDrawings));
  EXPECT_TRUE(budget.take(12'500, Priority::kTrajectories));
  EXPECT_FALSE(budget.take(1, Priority::kTrajectories));
  EXPECT_TRUE(budget.take(25'000, Priority::kEssential));
  EXPECT_FALSE(budget.take(1, Priority::kEssential));
}

TEST(ByteBudget, TheSmallestBudgetStillLetsAPieceThrough) {
  ByteBudget budget(10'000, 20'000);
  EXPECT_TRUE(budget.take(20'000, Priority::kPoints));
}

TEST(ByteBudget, WhatIsSentAnywayIsTakenFromLaterOnes) {
  ByteBudget budget(400'000, 4096);
  budget.refill(0);
  budget.charge(120'000);
  EXPECT_FALSE(budget.take(1, Priority::kEssential));
  budget.refill(kSecond_ns / 10);
  EXPECT_TRUE(budget.take(20'000, Priority::kEssential));
  EXPECT_FALSE(budget.take(1, Priority::kEssential));
}

}  // namespace
}  // namespace kinetrace::publishing
