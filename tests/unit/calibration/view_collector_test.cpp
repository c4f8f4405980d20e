#include "view_collector.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "board_scene.hpp"

namespace kinetrace::calibration {
namespace {

using ::testing::Contains;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::Not;

class Collector : public ::testing::Test {
 protected:
  // A board that faces the camera, turned by these angles about the image's axes.
  [[nodiscard]] BoardView view(const Eigen::Vector3d& centre_m, const Eigen::Vector2d& turn_rad = {0.0, 0.0}) const {
    const Eigen::Matrix3d R = so3_exp({turn_rad.x(), turn_rad.y(), 0.0});
    const Se3 pose{R, centre_m - R * Eigen::Vector3d(0.12, 0.075, 0.0)};
    return test::ideal_views(rig_, target_, {pose}, 0.0, 1).front();
  }

  hal::RigCalibration rig_ = test::true_rig(Lens::kRadialTangential);
  Target target_ = chessboard_target(9, 6, 0.03);
  ViewCollector views_{target_, Lens::kRadialTangential, 640, 480};
};

TEST_F(Collector, TakesViewsThatDiffer) {
  EXPECT_EQ(views_.offer(view({0.05, 0.0, 0.6})), Offer::kTaken);
  EXPECT_EQ(views_.offer(view({0.052, 0.001, 0.6})), Offer::kSimilar);
  EXPECT_EQ(views_.offer(view({0.15, 0.0, 0.6})), Offer::kTaken);
  EXPECT_EQ(views_.offer(view({0.05, 0.0, 0.6}, {0.4, 0.0})), Offer::kTaken);
  EXPECT_EQ(views_.offer({}), Offer::kNoTarget);
  BoardView half = view({0.0, 0.0, 0.9});
  half.right.clear();
  EXPECT_EQ(views_.offer(half), Offer::kOneImageOnly);
  EXPECT_EQ(views_.count(Offer::kTaken), 3U);
  EXPECT_EQ(views_.views().size(), 3U);
}

TEST_F(Collector, TellsTheDirectionsOfTilts) {
  static_cast<void>(views_.offer(view({0.05, 0.0, 0.6}, {-0.5, 0.0})));  // The upper edge goes away.
  EXPECT_EQ(views_.assess().tilted, (std::array<int, 4>{1, 0, 0, 0}));
  EXPECT_THAT(views_.assess().missing, Not(Contains(HasSubstr("upper edge"))));
  EXPECT_THAT(views_.assess().missing, Contains(HasSubstr("lower edge")));
  static_cast<void>(views_.offer(view({0.05, 0.0, 0.6}, {0.0, 0.5})));  // The left edge goes away.
  EXPECT_EQ(views_.assess().tilted, (std::array<int, 4>{1, 0, 1, 0}));
}

TEST_F(Collector, SaysWhatIsMissingUntilNothingIs) {
  EXPECT_THAT(views_.assess().missing, Contains("show the target to both cameras"));
  EXPECT_THAT(views_.assess().refusals, Contains(HasSubstr("0 views are too few")));
  for (const Se3& pose : test::board_poses(rig_, target_, {.views = 100, .max_tilt_rad = 0.7, .spread = 1.1}, 3)) {
    static_cast<void>(views_.offer(test::ideal_views(rig_, target_, {pose}, 0.0, 1).front()));
  }
  const Assessment assessment = views_.assess();
  EXPECT_THAT(assessment.refusals, IsEmpty());
  EXPECT_THAT(assessment.missing, IsEmpty());
  EXPECT_GT(assessment.left_coverage, 0.75);
  EXPECT_NEAR(assessment.nearest_m, 0.35, 0.15);
}

TEST_F(Collector, NamesThePartOfTheImageThatIsEmpty) {
  for (int i = 0; i < 12; ++i) {
    static_cast<void>(views_.offer(view({0.35 + 0.01 * (i % 3), 0.25, 0.8}, {0.15 * (i - 6), 0.1 * (i % 4)})));
  }
  EXPECT_THAT(views_.assess().refusals, Contains(HasSubstr("of the left image; move it through the whole image")));
  EXPECT_THAT(views_.assess().missing, Contains(HasSubstr("top left of the left image")));
}

}  // namespace
}  // namespace kinetrace::calibration
