#include "stereo_estimation.hpp"

#include <cmath>
#include <numbers>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "board_scene.hpp"

namespace kinetrace::calibration {
namespace {

using test::board_poses;
using test::ideal_views;
using test::true_rig;
using ::testing::HasSubstr;

// Noise of a good detector on a sharp image.
constexpr double kNoise_px = 0.05;

// (rotation, translation) errors in the units of the covariance, then errors of the lenses.
ParameterVector errors_of(const StereoEstimate& estimate, const hal::RigCalibration& truth) {
  const auto camera = [](const hal::CameraModel& model) {
    Eigen::Matrix<double, kCameraParameters, 1> values;
    values << model.fx_px, model.fy_px, model.cx_px, model.cy_px,
        Eigen::Map<const Eigen::Matrix<double, 8, 1>>(model.distortion.data());
    return values;
  };
  ParameterVector errors;
  errors << camera(estimate.rig.left) - camera(truth.left), camera(estimate.rig.right) - camera(truth.right),
      left_difference(truth.T_right_left, estimate.rig.T_right_left);
  return errors;
}

Result<StereoEstimate> estimated(Lens lens, std::uint32_t seed, double noise_px = kNoise_px, int views_count = 60) {
  const hal::RigCalibration truth = true_rig(lens);
  const Target target = charuco_target(11, 8, 0.03, 0.022, "DICT_4X4_100");
  const auto views =
      ideal_views(truth, target, board_poses(truth, target, {.views = views_count}, seed), noise_px, seed + 1000);
  return estimate_stereo(target, views, {.lens = lens, .width_px = 640, .height_px = 480});
}

class EveryLens : public ::testing::TestWithParam<Lens> {};

TEST_P(EveryLens, IsFoundFromCornersWithNoise) {
  const hal::RigCalibration truth = true_rig(GetParam());
  for (std::uint32_t seed = 1; seed <= 2; ++seed) {
    const auto estimate = estimated(GetParam(), seed);
    ASSERT_TRUE(estimate) << estimate.error().message;
    EXPECT_NEAR(estimate->sigma_px, kNoise_px, 0.05 * kNoise_px);
    EXPECT_NEAR(estimate->rig.left.fx_px, truth.left.fx_px, 1e-3 * truth.left.fx_px);
    EXPECT_NEAR(estimate->rig.right.fx_px, truth.right.fx_px, 1e-3 * truth.right.fx_px);
    const Vector6d pose = left_difference(truth.T_right_left, estimate->rig.T_right_left);
    EXPECT_LT(pose.head<3>().norm() * 180.0 / std::numbers::pi, 0.01);
    EXPECT_LT(pose.tail<3>().norm(), 2e-4);
  }
}

INSTANTIATE_TEST_SUITE_P(StereoEstimation, EveryLens,
                         ::testing::Values(Lens::kRadialTangential, Lens::kRadialTangential5, Lens::kRational,
                                           Lens::kFisheye));

TEST(StereoEstimation, WithoutNoiseFindsTheTruth) {
  const auto estimate = estimated(Lens::kRadialTangential, 1, 0.0);
  ASSERT_TRUE(estimate) << estimate.error().message;
  EXPECT_LT(errors_of(*estimate, true_rig(Lens::kRadialTangential)).cwiseAbs().maxCoeff(), 1e-4);
}

TEST(StereoEstimation, SigmasAreThoseOfTheErrors) {
  const hal::RigCalibration truth = true_rig(Lens::kRadialTangential);
  double sum = 0.0;
  int count = 0;
  for (std::uint32_t seed = 1; seed <= 12; ++seed) {
    const auto estimate = estimated(Lens::kRadialTangential, seed, kNoise_px, 20);
    ASSERT_TRUE(estimate) << estimate.error().message;
    const ParameterVector sigmas = estimate->sigmas();
    const ParameterVector errors = errors_of(*estimate, truth);
    for (int i = 0; i < kParameters; ++i) {
      if (sigmas(i) > 0.0) {
        sum += errors(i) * errors(i) / (sigmas(i) * sigmas(i));
        ++count;
      } else {
        EXPECT_EQ(errors(i), 0.0) << parameter_name(i);
      }
    }
  }
  EXPECT_EQ(count, 12 * 22);
  EXPECT_GT(sum / count, 0.6);
  EXPECT_LT(sum / count, 1.6);
}

TEST(StereoEstimation, LeavesOutViewsAndCornersThatContradictTheRest) {
  const hal::RigCalibration truth = true_rig(Lens::kRadialTangential);
  const Target target = charuco_target(11, 8, 0.03, 0.022, "DICT_4X4_100");
  auto views = ideal_views(truth, target, board_poses(truth, target, {}, 5), kNoise_px, 6);
  // The right image of one view shows another moment; some corners are outliers.
  views[4].right = views[9].right;
  for (std::size_t i = 10; i < 20; ++i) {
    views[i].left.front().px += Eigen::Vector2d(7.0, -3.0);
  }
  const auto estimate =
      estimate_stereo(target, views, {.lens = Lens::kRadialTangential, .width_px = 640, .height_px = 480});
  ASSERT_TRUE(estimate) << estimate.error().message;
  EXPECT_THAT(estimate->used_views, ::testing::Not(::testing::Contains(4U)));
  EXPECT_NEAR(estimate->rig.left.fx_px, truth.left.fx_px, 1e-3 * truth.left.fx_px);
  EXPECT_NEAR(estimate->sigma_px, kNoise_px, 0.05 * kNoise_px);
}

TEST(StereoEstimation, RefusesViewsThatShowNothing) {
  const Target target = chessboard_target(9, 6, 0.03);
  const std::vector<BoardView> nothing(5);
  for (const std::span<const BoardView> views : {std::span<const BoardView>(), std::span<const BoardView>(nothing)}) {
    const auto estimate = estimate_stereo(target, views, {.width_px = 640, .height_px = 480});
    ASSERT_FALSE(estimate);
    EXPECT_EQ(estimate.error().code, ErrorCode::kBadCalibration);
    EXPECT_THAT(estimate.error().message, HasSubstr("--target"));
  }
}

}  // namespace
}  // namespace kinetrace::calibration
