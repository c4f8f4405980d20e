#include "shift_group.hpp"

#include <algorithm>
#include <vector>

#include <gtest/gtest.h>

namespace kinetrace::pipeline {
namespace {

constexpr double kMost_m = 0.8;
constexpr double kRadius_m = 0.15;

std::vector<std::uint16_t> members(const ShiftGroup& group) {
  std::vector<std::uint16_t> indices(group.members.begin(),
                                     group.members.begin() + static_cast<std::ptrdiff_t>(group.count));
  std::sort(indices.begin(), indices.end());
  return indices;
}

TEST(ShiftGroup, IsEmptyOfNothing) {
  EXPECT_EQ(largest_group({}, kMost_m, kRadius_m).count, 0U);
}

TEST(ShiftGroup, IsWhatMostAgreeOn) {
  const std::vector<Likeness> likenesses{{1, 1, {0.1, 0.0, 0.0}},
                                         {2, 2, {0.2, 0.0, 0.0}},
                                         {3, 3, {0.15, 0.03, 0.0}},
                                         {4, 4, {-0.4, 0.0, 0.0}},
                                         {5, 5, {-0.4, 0.0, 0.0}}};
  const ShiftGroup group = largest_group(likenesses, kMost_m, kRadius_m);
  EXPECT_EQ(members(group), (std::vector<std::uint16_t>{0, 1, 2}));
  EXPECT_TRUE(group.shift_m.isApprox(Eigen::Vector3d(0.15, 0.01, 0.0)));
}

TEST(ShiftGroup, HearsAFeatureThatLooksLikeSeveralPointsOnce) {
  const std::vector<Likeness> likenesses{{1, 1, {0.1, 0.0, 0.0}},
                                         {1, 2, {0.0, 0.0, 0.0}},
                                         {1, 3, {0.05, 0.0, 0.0}},
                                         {2, 4, {0.5, 0.0, 0.0}},
                                         {3, 5, {0.5, 0.0, 0.0}}};
  EXPECT_EQ(members(largest_group(likenesses, kMost_m, kRadius_m)), (std::vector<std::uint16_t>{3, 4}));
}

TEST(ShiftGroup, HearsAPointThatSeveralFeaturesLookLikeOnce) {
  const std::vector<Likeness> likenesses{{1, 1, {0.1, 0.0, 0.0}},
                                         {2, 1, {0.0, 0.0, 0.0}},
                                         {3, 1, {0.05, 0.0, 0.0}},
                                         {4, 2, {0.5, 0.0, 0.0}},
                                         {5, 3, {0.5, 0.0, 0.0}}};
  EXPECT_EQ(members(largest_group(likenesses, kMost_m, kRadius_m)), (std::vector<std::uint16_t>{3, 4}));
}

TEST(ShiftGroup, KeepsTheNearestOfThoseThatCompete) {
  const std::vector<Likeness> likenesses{
      {1, 1, {0.14, 0.0, 0.0}}, {1, 2, {0.01, 0.0, 0.0}}, {2, 3, {0.0, 0.0, 0.0}}, {3, 4, {-0.05, 0.0, 0.0}}};
  EXPECT_EQ(members(largest_group(likenesses, kMost_m, kRadius_m)), (std::vector<std::uint16_t>{1, 2, 3}));
}

TEST(ShiftGroup, LeavesOutWhatIsTooFarOff) {
  const std::vector<Likeness> likenesses{{1, 1, {0.9, 0.0, 0.0}}, {2, 2, {0.9, 0.0, 0.0}}, {3, 3, {0.3, 0.0, 0.0}}};
  EXPECT_EQ(members(largest_group(likenesses, kMost_m, kRadius_m)), (std::vector<std::uint16_t>{2}));
}

TEST(ShiftGroup, HoldsSoManyMembers) {
  for (const std::size_t count : {ShiftGroup::kMaxMembers, ShiftGroup::kMaxMembers + 1}) {
    std::vector<Likeness> likenesses;
    for (std::size_t i = 0; i < count; ++i) {
      likenesses.push_back({static_cast<std::uint16_t>(i), static_cast<std::uint16_t>(i), Eigen::Vector3d::Zero()});
    }
    EXPECT_EQ(largest_group(likenesses, kMost_m, kRadius_m).count, ShiftGroup::kMaxMembers);
  }
}

}  // namespace
}  // namespace kinetrace::pipeline
