#include "row_hull.hpp"

#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace kinetrace::segmentation {
namespace {

using testing::ElementsAre;

std::vector<float> convex(std::vector<float> first_column) {
  make_convex(first_column);
  return first_column;
}

TEST(RowHull, ConnectsCornersByStraightLines) {
  EXPECT_THAT(convex({4.F, 6.F, 2.F, 9.F, 4.F}), ElementsAre(4.F, 3.F, 2.F, 3.F, 4.F));
}

TEST(RowHull, LeavesWhatIsConvex) {
  EXPECT_THAT(convex({5.F, 2.F, 1.F, 1.F, 3.F}), ElementsAre(5.F, 2.F, 1.F, 1.F, 3.F));
}

TEST(RowHull, FillsRowsWithoutPixelsBetweenOthers) {
  EXPECT_THAT(convex({kNoColumn, 4.F, kNoColumn, 2.F, kNoColumn}), ElementsAre(kNoColumn, 4.F, 3.F, 2.F, kNoColumn));
}

TEST(RowHull, OfNothingIsNothing) {
  EXPECT_THAT(convex({}), ElementsAre());
  EXPECT_THAT(convex({kNoColumn, kNoColumn}), ElementsAre(kNoColumn, kNoColumn));
  EXPECT_THAT(convex({7.F}), ElementsAre(7.F));
}

TEST(RowHull, OfTheRightSideTakesNegatedColumns) {
  EXPECT_THAT(convex({-6.F, -2.F, -8.F}), ElementsAre(-6.F, -7.F, -8.F));
}

}  // namespace
}  // namespace kinetrace::segmentation
