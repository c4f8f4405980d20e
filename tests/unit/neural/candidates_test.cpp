#include "candidates.hpp"

#include <limits>
#include <vector>

#include <gtest/gtest.h>

namespace kinetrace::neural {
namespace {

Candidate candidate(float score, Box box, int class_index = 0) {
  return {box, score, class_index, {}};
}

class Candidates : public ::testing::Test {
 protected:
  Arena arena_{1 << 16};
  CandidateList list_{arena_, 4};
};

TEST_F(Candidates, OverlapIsIntersectionOverUnion) {
  EXPECT_FLOAT_EQ(overlap({0, 0, 10, 10}, {0, 0, 10, 10}), 1.F);
  EXPECT_FLOAT_EQ(overlap({0, 0, 10, 10}, {5, 0, 15, 10}), 50.F / 150.F);
  EXPECT_FLOAT_EQ(overlap({0, 0, 10, 10}, {10, 0, 20, 10}), 0.F);
  EXPECT_FLOAT_EQ(overlap({0, 0, 0, 0}, {0, 0, 0, 0}), 0.F);
}

TEST_F(Candidates, TheWeakerOfTwoThatOverlapGoes) {
  list_.add(candidate(0.6F, {1, 0, 11, 10}));
  list_.add(candidate(0.9F, {0, 0, 10, 10}));
  list_.suppress(0.5F);
  ASSERT_EQ(list_.all().size(), 1U);
  EXPECT_FLOAT_EQ(list_.all()[0].score, 0.9F);
}

TEST_F(Candidates, WhatOverlapsNoMoreThanAllowedStays) {
  list_.add(candidate(0.6F, {5, 0, 15, 10}));
  list_.add(candidate(0.9F, {0, 0, 10, 10}));
  list_.suppress(0.34F);
  EXPECT_EQ(list_.all().size(), 2U);
}

TEST_F(Candidates, ClassesDoNotSuppressEachOther) {
  list_.add(candidate(0.6F, {0, 0, 10, 10}, 1));
  list_.add(candidate(0.9F, {0, 0, 10, 10}, 0));
  list_.suppress(0.5F);
  EXPECT_EQ(list_.all().size(), 2U);
}

TEST_F(Candidates, WhatIsSuppressedDoesNotSuppress) {
  list_.add(candidate(0.9F, {0, 0, 10, 10}));
  list_.add(candidate(0.8F, {4, 0, 14, 10}));
  list_.add(candidate(0.7F, {8, 0, 18, 10}));
  list_.suppress(0.4F);
  ASSERT_EQ(list_.all().size(), 2U);
  EXPECT_FLOAT_EQ(list_.all()[1].score, 0.7F);
}

TEST_F(Candidates, AtCapacityTheWeakestGo) {
  for (int i = 0; i < 6; ++i) {
    const float at = 100.F * static_cast<float>(i);
    list_.add(candidate(0.1F * static_cast<float>(i + 1), {at, 0, at + 10, 10}));
  }
  EXPECT_EQ(list_.dropped(), 2U);
  list_.suppress(0.5F);
  ASSERT_EQ(list_.all().size(), 4U);
  EXPECT_FLOAT_EQ(list_.all()[0].score, 0.6F);
  EXPECT_FLOAT_EQ(list_.all()[3].score, 0.3F);
}

TEST_F(Candidates, NoNumbersAndEmptyBoxesAreLeftOut) {
  constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
  constexpr float kInfinity = std::numeric_limits<float>::infinity();
  list_.add(candidate(kNan, {0, 0, 10, 10}));
  list_.add(candidate(0.5F, {0, 0, kInfinity, 10}));
  list_.add(candidate(0.5F, {kNan, 0, 10, 10}));
  list_.add(candidate(0.5F, {5, 0, 5, 10}));
  list_.add(candidate(0.5F, {8, 0, 5, 10}));
  EXPECT_TRUE(list_.all().empty());
}

}  // namespace
}  // namespace kinetrace::neural
