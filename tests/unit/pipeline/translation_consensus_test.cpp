#include "translation_consensus.hpp"

#include <algorithm>
#include <vector>

#include <gtest/gtest.h>

namespace kinetrace::pipeline {
namespace {

constexpr double kMax_m = 0.8;
constexpr double kRadius_m = 0.15;

std::vector<std::uint16_t> members(const TranslationConsensus& group) {
  std::vector<std::uint16_t> indices(group.members.begin(),
                                     group.members.begin() + static_cast<std::ptrdiff_t>(group.count));
  std::sort(indices.begin(), indices.end());
  return indices;
}

TEST(TranslationConsensus, IsEmptyOfNothing) {
  EXPECT_EQ(largest_group({}, kMax_m, kRadius_m).count, 0U);
}

TEST(TranslationConsensus, IsWhatMostAgreeOn) {
  const std::vector<AppearanceMatch> matches{{1, 1, {0.1, 0.0, 0.0}},
                                             {2, 2, {0.2, 0.0, 0.0}},
                                             {3, 3, {0.15, 0.03, 0.0}},
                                             {4, 4, {-0.4, 0.0, 0.0}},
                                             {5, 5, {-0.4, 0.0, 0.0}}};
  EXPECT_EQ(members(largest_group(matches, kMax_m, kRadius_m)), (std::vector<std::uint16_t>{0, 1, 2}));
}

TEST(TranslationConsensus, HearsAFeatureThatLooksLikeSeveralPointsOnce) {
  const std::vector<AppearanceMatch> matches{{1, 1, {0.1, 0.0, 0.0}},
                                             {1, 2, {0.0, 0.0, 0.0}},
                                             {1, 3, {0.05, 0.0, 0.0}},
                                             {2, 4, {0.5, 0.0, 0.0}},
                                             {3, 5, {0.5, 0.0, 0.0}}};
  EXPECT_EQ(members(largest_group(matches, kMax_m, kRadius_m)), (std::vector<std::uint16_t>{3, 4}));
}

TEST(TranslationConsensus, HearsAPointThatSeveralFeaturesLookLikeOnce) {
  const std::vector<AppearanceMatch> matches{{1, 1, {0.1, 0.0, 0.0}},
                                             {2, 1, {0.0, 0.0, 0.0}},
                                             {3, 1, {0.05, 0.0, 0.0}},
                                             {4, 2, {0.5, 0.0, 0.0}},
                                             {5, 3, {0.5, 0.0, 0.0}}};
  EXPECT_EQ(members(largest_group(matches, kMax_m, kRadius_m)), (std::vector<std::uint16_t>{3, 4}));
}

TEST(TranslationConsensus, KeepsTheNearestOfThoseThatCompete) {
  const std::vector<AppearanceMatch> matches{
      {1, 1, {0.14, 0.0, 0.0}}, {1, 2, {0.01, 0.0, 0.0}}, {2, 3, {0.0, 0.0, 0.0}}, {3, 4, {-0.05, 0.0, 0.0}}};
  EXPECT_EQ(members(largest_group(matches, kMax_m, kRadius_m)), (std::vector<std::uint16_t>{1, 2, 3}));
}

TEST(TranslationConsensus, LeavesOutWhatIsTooFarOff) {
  const std::vector<AppearanceMatch> matches{{1, 1, {0.9, 0.0, 0.0}}, {2, 2, {0.9, 0.0, 0.0}}, {3, 3, {0.3, 0.0, 0.0}}};
  EXPECT_EQ(members(largest_group(matches, kMax_m, kRadius_m)), (std::vector<std::uint16_t>{2}));
}

TEST(TranslationConsensus, HoldsSoManyMembers) {
  for (const std::size_t count : {TranslationConsensus::kMaxMembers, TranslationConsensus::kMaxMembers + 1}) {
    std::vector<AppearanceMatch> matches;
    for (std::size_t i = 0; i < count; ++i) {
      matches.push_back({static_cast<std::uint16_t>(i), static_cast<std::uint16_t>(i), Eigen::Vector3d::Zero()});
    }
    EXPECT_EQ(largest_group(matches, kMax_m, kRadius_m).count, TranslationConsensus::kMaxMembers);
  }
}

}  // namespace
}  // namespace kinetrace::pipeline
