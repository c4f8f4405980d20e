#include "kinetrace/evaluation/matching.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace kinetrace::evaluation {
namespace {

using ::testing::ElementsAre;
using ::testing::IsEmpty;

TEST(BestMatching, HasNothingToMatchWithoutRowsOrColumns) {
  EXPECT_THAT(best_matching(Eigen::MatrixXd(0, 3)), IsEmpty());
  EXPECT_THAT(best_matching(Eigen::MatrixXd(2, 0)), ElementsAre(-1, -1));
}

TEST(BestMatching, PrefersTheGreatestSumToTheGreatestPair) {
  Eigen::MatrixXd weights(2, 2);
  weights << 0.9, 0.8, 0.8, 0.1;
  EXPECT_THAT(best_matching(weights), ElementsAre(1, 0));
}

TEST(BestMatching, LeavesPairsWithoutWeightApart) {
  Eigen::MatrixXd weights(3, 2);
  weights << 0.0, 0.7, 0.0, 0.0, 0.0, 0.6;
  EXPECT_THAT(best_matching(weights), ElementsAre(1, -1, -1));
}

TEST(BestMatching, HoldsMoreObjectsThanARunMayTrack) {
  constexpr int kMany = 150;
  Eigen::MatrixXd weights = Eigen::MatrixXd::Constant(kMany, kMany, 0.1);
  for (int i = 0; i < kMany; ++i) {
    weights(i, (i + 7) % kMany) = 1.0;
  }
  const std::vector<int> matching = best_matching(weights);
  for (int i = 0; i < kMany; ++i) {
    EXPECT_EQ(matching[static_cast<std::size_t>(i)], (i + 7) % kMany);
  }
}

}  // namespace
}  // namespace kinetrace::evaluation
