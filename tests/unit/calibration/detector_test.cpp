#include "detector.hpp"

#include <algorithm>
#include <cmath>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "board_scene.hpp"
#include "rendered_board.hpp"

namespace kinetrace::calibration {
namespace {

using kinetrace::test::BoardImageFaults;
using kinetrace::test::BoardRenderer;

struct Errors {
  int corners = 0;
  int visible = 0;  ///< Points of the target inside the image.
  Eigen::Vector2d mean_px = Eigen::Vector2d::Zero();
  double rms_px = 0.0;
  double max_px = 0.0;
};

// Detections of a target in a dozen poses, against its true points.
Errors detection_errors(const Target& target, const BoardImageFaults& faults) {
  const hal::RigCalibration rig = test::true_rig(Lens::kRadialTangential);
  const BoardRenderer renderer(target, rig.left);
  auto detector = make_detector(target);
  EXPECT_TRUE(detector);
  Errors errors;
  std::uint32_t seed = 1;
  for (const Se3& pose : test::board_poses(rig, target, {.views = 12, .far_m = 0.7, .spread = 0.4}, 3)) {
    const auto image = renderer.render(pose, faults, seed++);
    for (const Eigen::Vector3d& point : target.points_m) {
      const Eigen::Vector2d px = rig.left.project(pose * point);
      constexpr double kBorder_px = 6.0;
      errors.visible += px.x() > kBorder_px && px.y() > kBorder_px && px.x() < rig.left.width_px - kBorder_px &&
                                px.y() < rig.left.height_px - kBorder_px
                            ? 1
                            : 0;
    }
    for (const Corner& corner : (*detector)->detect(image.view())) {
      const Eigen::Vector2d error =
          corner.px - rig.left.project(pose * target.points_m[static_cast<std::size_t>(corner.id)]);
      ++errors.corners;
      errors.mean_px += error;
      errors.rms_px += error.squaredNorm();
      errors.max_px = std::max(errors.max_px, error.norm());
    }
  }
  errors.mean_px /= std::max(errors.corners, 1);
  errors.rms_px = std::sqrt(errors.rms_px / std::max(errors.corners, 1));
  std::printf("%s: %d corners of %d, mean %.3f %.3f, rms %.3f, max %.3f px\n", target.description().c_str(),
              errors.corners, errors.visible, errors.mean_px.x(), errors.mean_px.y(), errors.rms_px, errors.max_px);
  return errors;
}

void expect_exact(const Errors& errors, int least_corners) {
  EXPECT_GE(errors.corners, least_corners);
  EXPECT_LT(errors.mean_px.norm(), 0.02);
  EXPECT_LT(errors.rms_px, 0.12);
  EXPECT_LT(errors.max_px, 1.0);
}

TEST(ChessboardDetector, FindsCornersToATenthOfAPixel) {
  expect_exact(detection_errors(chessboard_target(9, 6, 0.025), {}), 9 * 54);
}

TEST(ChessboardDetector, NumbersABoardWithTwoEvenSidesAlikeInBothImages) {
  const Target target = chessboard_target(8, 6, 0.025);
  const hal::RigCalibration rig = test::true_rig(Lens::kRadialTangential);
  const BoardRenderer left(target, rig.left);
  const BoardRenderer right(target, rig.right);
  const auto detector = make_detector(target);
  ASSERT_TRUE(detector);
  for (const Se3& pose : test::board_poses(rig, target, {.views = 6, .near_m = 0.6, .spread = 0.3}, 3)) {
    const auto left_image = left.render(pose, {}, 1);
    const auto right_image = right.render(rig.T_right_left * pose, {}, 2);
    const BoardView view = (*detector)->detect_pair(left_image.view(), right_image.view());
    if (view.left.empty() || view.right.empty()) {
      continue;
    }
    // The right camera's image has the points further to the left.
    for (std::size_t i = 0; i < view.left.size(); ++i) {
      EXPECT_LT(view.right[i].px.x(), view.left[i].px.x() + 30.0);
      EXPECT_NEAR(view.right[i].px.y(), view.left[i].px.y(), 40.0);
    }
  }
}

TEST(CharucoDetector, FindsCornersAlsoWhereTheBoardIsPartlyCovered) {
  const Target target = charuco_target(9, 6, 0.03, 0.022, "DICT_4X4_100");
  expect_exact(detection_errors(target, {}), 8 * 40);
  expect_exact(detection_errors(target, {.covered = 0.4}), 3 * 40);
}

TEST(CharucoDetector, KnowsOldBoardsWithAnEvenNumberOfRows) {
  const Target old = charuco_target(9, 6, 0.03, 0.022, "DICT_4X4_100", true);
  EXPECT_EQ(old.markers.size(), 27U);
  EXPECT_LT(old.markers[0].corners_m[0].x(), -0.02);
  const Target now = charuco_target(9, 6, 0.03, 0.022, "DICT_4X4_100");
  EXPECT_GT(now.markers[0].corners_m[0].x(), 0.0);
}

TEST(CharucoDetector, RefusesADictionaryThatIsNone) {
  const auto detector = make_detector(charuco_target(9, 6, 0.03, 0.022, "DICT_3X3_7"));
  ASSERT_FALSE(detector);
  EXPECT_EQ(detector.error().code, ErrorCode::kInvalidArgument);
  EXPECT_THAT(detector.error().message, ::testing::HasSubstr("DICT_3X3_7"));
}

TEST(AprilDetector, FindsCornersAlsoWhereTheGridIsPartlyCovered) {
  for (const int border_bits : {1, 2}) {
    const Target target = april_grid_target(5, 4, 0.04, 0.3, border_bits);
    expect_exact(detection_errors(target, {}), 8 * 80);
    expect_exact(detection_errors(target, {.covered = 0.4}), 3 * 80);
  }
}

TEST(EveryDetector, SeesNothingWhereThereIsNothing) {
  const std::vector<std::uint8_t> grey(640UL * 480UL, 128);
  const std::vector<std::uint8_t> dots = [] {
    std::vector<std::uint8_t> pixels(640UL * 480UL);
    std::uint32_t state = 1;
    for (std::uint8_t& pixel : pixels) {
      state = state * 1664525U + 1013904223U;
      pixel = static_cast<std::uint8_t>(state >> 24U);
    }
    return pixels;
  }();
  for (const Target& target : {chessboard_target(9, 6, 0.03), charuco_target(9, 6, 0.03, 0.022, "DICT_4X4_100"),
                               april_grid_target(6, 6, 0.03, 0.3)}) {
    const auto detector = make_detector(target);
    ASSERT_TRUE(detector);
    EXPECT_TRUE((*detector)->detect({grey.data(), 640, 480, 640}).empty());
    EXPECT_TRUE((*detector)->detect({dots.data(), 640, 480, 640}).empty());
  }
}

}  // namespace
}  // namespace kinetrace::calibration
