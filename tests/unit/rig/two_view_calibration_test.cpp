#include "two_view_calibration.hpp"

#include <cmath>
#include <vector>

#include <gtest/gtest.h>

#include "turned_rig.hpp"

namespace kinetrace::rig {
namespace {

using test::kDegree_rad;
using test::see;
using test::StreetOfPoints;
using test::turned;

constexpr int kRig = RigCorrection::kSize;

struct Drive {
  RigCorrection before;
  RigCorrection now;
  Se3 T_now_before{so3_exp({0.001, 0.004, -0.002}), {0.02, -0.01, -1.9}};
  double follow_px = 0.0;
  double match_px = 0.0;
  int movers = 0;  ///< Moving points.
};

std::vector<TwoViewPoint> drive(const Drive& d, int count, std::uint32_t seed) {
  StreetOfPoints street(seed);
  std::vector<TwoViewPoint> points;
  for (int i = 0; i < count; ++i) {
    const Eigen::Vector3d p = street.point();
    const Eigen::Vector3d q =
        d.T_now_before * p + (i < d.movers ? Eigen::Vector3d(0.3, 0.0, 0.8) : Eigen::Vector3d::Zero());
    const auto a = see(test::street_rig(), d.before, p);
    const auto b = see(test::street_rig(), d.now, q);
    const auto noisy = [&](double sigma) { return Eigen::Vector2d(street.noise(sigma), street.noise(sigma)); };
    // A matching error persists for its point.
    const Eigen::Vector2d of_point = noisy(d.match_px);
    points.push_back({a.left_px.cast<float>(), (a.right_px + of_point).cast<float>(),
                      (b.left_px + noisy(d.follow_px)).cast<float>(),
                      (b.right_px + of_point + noisy(0.5 * d.match_px)).cast<float>()});
  }
  return points;
}

RigMeasurement calibrate(const Drive& d, int count = 160, std::uint32_t seed = 1, bool focal_shown = false) {
  return calibrate_two_views(test::street_rig(), drive(d, count, seed), d.T_now_before, RigMeasurement::Vector::Zero(),
                             focal_shown);
}

TEST(TwoViewCalibration, FindsHowTheRightCameraStands) {
  Drive d;
  d.before = d.now = turned(0.3, -0.4, 0.25, 0.2, -0.3);
  const RigMeasurement found = calibrate(d);
  ASSERT_TRUE(found.valid);
  EXPECT_EQ(found.points, 160);
  const RigCorrection::Vector error = found.value.head<kRig>() - d.now.vector();
  EXPECT_LT(error.head<3>().cwiseAbs().maxCoeff(), 0.001 * kDegree_rad) << error.transpose() / kDegree_rad;
  EXPECT_LT(found.value.tail<kRig>().cwiseAbs().maxCoeff(), 0.001 * kDegree_rad);
}

TEST(TwoViewCalibration, FindsWhatChangesBetweenTheFrames) {
  Drive d;
  d.before = turned(0.1, 0.05, -0.1);
  d.now = turned(0.12, 0.08, -0.09);
  const RigMeasurement found = calibrate(d);
  ASSERT_TRUE(found.valid);
  const RigCorrection::Vector change = found.value.tail<kRig>() - (d.now.vector() - d.before.vector());
  EXPECT_LT(change.head<3>().cwiseAbs().maxCoeff(), 0.001 * kDegree_rad) << change.transpose() / kDegree_rad;
}

// Lens distortion looks like a shift, so a prior constrains it; the common error of disparities is correct anyway.
TEST(TwoViewCalibration, AShiftAndATurnAreRightTogether) {
  Drive d;
  d.before = d.now = turned(0.0, 0.1, 0.0, 0.0, 0.0, 0.02);
  const RigMeasurement found = calibrate(d, 400);
  ASSERT_TRUE(found.valid);
  EXPECT_NEAR(found.value[1] + found.value[5], 0.12 * kDegree_rad, 0.004 * kDegree_rad);
  EXPECT_GT(found.value[5], 0.0);
}

TEST(TwoViewCalibration, ItsSigmasAreHonestWhereErrorsStayWithTheirPoints) {
  constexpr int kRuns = 40;
  Drive d;
  d.before = d.now = turned(-0.2, 0.3, 0.1);
  d.follow_px = 0.12;
  d.match_px = 0.12;
  RigCorrection::Vector squared = RigCorrection::Vector::Zero();
  for (std::uint32_t seed = 1; seed <= kRuns; ++seed) {
    const RigMeasurement found = calibrate(d, 160, seed);
    ASSERT_TRUE(found.valid);
    const RigCorrection::Vector error = found.value.head<kRig>() - d.now.vector();
    squared.array() += error.array().square() / found.covariance.diagonal().head<kRig>().array();
    // The common error of disparities: turn and shift together.
    EXPECT_LT(std::abs(error[1] + error[5]) * test::street_rig().fx_px, 0.15) << seed;
  }
  // The shift has its own prior, and smaller errors.
  for (const int i : {0, 1, 2, 3, 4}) {
    EXPECT_GT(squared[i] / kRuns, 0.3) << i;
    EXPECT_LT(squared[i] / kRuns, 2.0) << i;
  }
}

TEST(TwoViewCalibration, ATurnShowsTheFocalLength) {
  constexpr int kRuns = 40;
  Drive d;
  d.T_now_before = {so3_exp({0.01, 0.16, 0.0}), {0.02, -0.01, -1.9}};
  d.before = d.now = turned(0.1, 0.2, 0.0, 0.0, 0.0, 0.0, 0.01);
  const RigMeasurement exact = calibrate(d, 160, 1, true);
  ASSERT_TRUE(exact.valid);
  EXPECT_NEAR(exact.value[RigCorrection::kFocal], 0.01, 0.0002);
  EXPECT_NEAR(exact.value[1], d.now.turn_rad.y(), 0.001 * kDegree_rad);
  d.follow_px = 0.12;
  d.match_px = 0.12;
  double squared = 0.0;
  for (std::uint32_t seed = 1; seed <= kRuns; ++seed) {
    const RigMeasurement found = calibrate(d, 160, seed, true);
    const double variance = found.covariance(RigCorrection::kFocal, RigCorrection::kFocal);
    EXPECT_LT(variance, 0.005 * 0.005);
    squared += (found.value[RigCorrection::kFocal] - 0.01) * (found.value[RigCorrection::kFocal] - 0.01) / variance;
  }
  EXPECT_GT(squared / kRuns, 0.3);
  EXPECT_LT(squared / kRuns, 2.0);
}

// Straight ahead a longer focal length is the same as a deeper scene.
TEST(TwoViewCalibration, AFocalLengthThatIsNotShownStays) {
  Drive d;
  d.before = d.now = turned(0.1, 0.2, 0.0, 0.0, 0.0, 0.0, 0.01);
  const RigMeasurement found = calibrate(d);
  ASSERT_TRUE(found.valid);
  EXPECT_NEAR(found.value[RigCorrection::kFocal], 0.0, 1e-6);
  EXPECT_GE(found.covariance(RigCorrection::kFocal, RigCorrection::kFocal), 1.0);
  EXPECT_NEAR(found.value[0], d.now.turn_rad.x(), 0.003 * kDegree_rad);
  EXPECT_NEAR(found.value[1] + found.value[5], d.now.turn_rad.y(), 0.003 * kDegree_rad);
}

TEST(TwoViewCalibration, PointsThatMoveByThemselvesHaveNoSay) {
  Drive d;
  d.before = d.now = turned(0.1, 0.2, 0.0);
  d.movers = 40;
  const RigMeasurement found = calibrate(d, 200);
  ASSERT_TRUE(found.valid);
  EXPECT_NEAR(found.value[1] + found.value[5], 0.2 * kDegree_rad, 0.002 * kDegree_rad);
  EXPECT_NEAR(found.value[0], 0.1 * kDegree_rad, 0.002 * kDegree_rad);
}

TEST(TwoViewCalibration, WithoutMotionItDoesNotPretendToKnowTheYaw) {
  Drive d;
  d.T_now_before = {};
  d.follow_px = 0.02;
  d.before = d.now = turned(0.0, 0.1, 0.0);
  const RigMeasurement found = calibrate(d);
  if (found.valid) {
    Eigen::Matrix<double, RigMeasurement::kSize, 1> both = Eigen::Matrix<double, RigMeasurement::kSize, 1>::Zero();
    both[1] = both[5] = 1.0;
    EXPECT_GT(std::sqrt(both.dot(found.covariance * both)), 0.01 * kDegree_rad);
  }
}

TEST(TwoViewCalibration, SurvivesWhatIsNoView) {
  EXPECT_NO_THROW(
      static_cast<void>(calibrate_two_views(test::street_rig(), {}, {}, RigMeasurement::Vector::Zero(), true)));
  std::vector<TwoViewPoint> points(60);
  for (TwoViewPoint& point : points) {
    point.left_before_px = point.right_before_px = point.left_px = point.right_px = {600.F, 170.F};
  }
  points[3].right_px = {std::nanf(""), 5.F};
  const RigMeasurement found =
      calibrate_two_views(test::street_rig(), points, {}, RigMeasurement::Vector::Zero(), true);
  EXPECT_TRUE(!found.valid || found.value.allFinite());
}

}  // namespace
}  // namespace kinetrace::rig
