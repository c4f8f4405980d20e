#include "drawing/label_placer.hpp"

#include <limits>

namespace kinetrace::drawing {
namespace {

constexpr Rect kArea{0, 0, 200, 100};

TEST(LabelPlacer, LabelsNeverOverlapNorLeaveTheArea) {
  LabelPlacer placer(kArea);
  std::vector<Rect> placed;
  for (int i = 0; i < 60; ++i) {
    if (const auto rect = placer.place({100.0, 50.0}, 30.0, 10.0, 4.0)) {
      for (const Rect& other : placed) {
        EXPECT_FALSE(rect->overlaps(other));
      }
      EXPECT_GE(rect->x, 0.0);
      EXPECT_LE(rect->right(), 200.0);
      EXPECT_GE(rect->y, 0.0);
      EXPECT_LE(rect->bottom(), 100.0);
      placed.push_back(*rect);
    }
  }
  EXPECT_GE(placed.size(), 6U);
  EXPECT_LT(placed.size(), 60U) << "there is only so much room near one point";
}

TEST(LabelPlacer, PrefersTheRightAndAvoidsTheEdge) {
  LabelPlacer placer(kArea);
  EXPECT_GT(placer.place({50.0, 50.0}, 30.0, 10.0, 4.0)->x, 50.0);
  EXPECT_LT(placer.place({199.0, 50.0}, 30.0, 10.0, 4.0)->x, 170.0);
}

TEST(LabelPlacer, AvoidsLines) {
  LabelPlacer placer(kArea);
  const std::vector<Point> line{{50.0, 50.0}, {150.0, 50.0}};
  placer.avoid(line);
  const auto rect = placer.place({50.0, 50.0}, 30.0, 10.0, 4.0);
  ASSERT_TRUE(rect);
  EXPECT_FALSE(rect->contains({rect->center().x(), 50.0}) && rect->right() > 52.0);
}

TEST(LabelPlacer, KeepsBlockedPlacesFree) {
  LabelPlacer placer(kArea);
  placer.block({0, 0, 200, 100});
  EXPECT_FALSE(placer.place({100.0, 50.0}, 10.0, 10.0, 4.0));
  EXPECT_FALSE(placer.place_at({10, 10, 20, 10}));
}

TEST(LabelPlacer, MovesAWantedPlaceIntoTheArea) {
  LabelPlacer placer(kArea);
  const auto rect = placer.place_at({-5, -3, 20, 10});
  ASSERT_TRUE(rect);
  EXPECT_DOUBLE_EQ(rect->x, 0.0);
  EXPECT_DOUBLE_EQ(rect->y, 0.0);
  EXPECT_FALSE(placer.place_at({-500, -3, 20, 10})) << "too far away to say what it belongs to";
  EXPECT_FALSE(placer.place_at({5, 5, 20, 10})) << "taken";
}

TEST(LabelPlacer, RefusesPointsThatAreNowhere) {
  LabelPlacer placer(kArea);
  EXPECT_FALSE(placer.place({std::numeric_limits<double>::quiet_NaN(), 1.0}, 10.0, 10.0, 4.0));
}

}  // namespace
}  // namespace kinetrace::drawing
