#include "kinetrace/core/rig_correction.hpp"

#include <cmath>
#include <limits>

#include <gtest/gtest.h>

#include "kinetrace/core/se3.hpp"
#include "synthetic_world.hpp"

namespace kinetrace {
namespace {

constexpr double kDegree_rad = M_PI / 180.0;

const StereoGeometry kRig = test::street_rig();

RigCorrection off() {
  return {kDegree_rad * Eigen::Vector3d(0.3, -0.4, 0.2), kDegree_rad * Eigen::Vector2d(0.3, -0.2), 0.05 * kDegree_rad,
          0.0};
}

// From the definition.
Eigen::Vector2d seen_by_right(const RigCorrection& rig, const Eigen::Vector3d& p) {
  const Eigen::Vector3d direction(1.0, rig.baseline_rad.x(), rig.baseline_rad.y());
  const Eigen::Vector3d q = so3_exp(-rig.turn_rad) * (p - kRig.baseline_m * direction.normalized());
  return {kRig.fx_px * (q.x() / q.z() - rig.shift_rad) + kRig.cx_px, kRig.fy_px * q.y() / q.z() + kRig.cy_px};
}

TEST(RigCorrection, SaysWhereTheRightCameraSeesAPoint) {
  for (const Eigen::Vector3d& p :
       {Eigen::Vector3d(0.0, 0.0, 20.0), Eigen::Vector3d(8.0, -2.0, 14.0), Eigen::Vector3d(-5.0, 1.5, 8.0)}) {
    const Eigen::Vector3d calibrated = kRig.project(p);
    const Eigen::Vector2d raw =
        off().raw_right_px(kRig, {calibrated.z(), calibrated.y()}, calibrated.x() - calibrated.z());
    EXPECT_LT((raw - seen_by_right(off(), p)).norm(), 0.02) << p.transpose();
  }
}

TEST(RigCorrection, ZeroChangesNothing) {
  EXPECT_TRUE(RigCorrection{}.is_zero());
  EXPECT_FALSE(off().is_zero());
  EXPECT_LT((RigCorrection{}.raw_right_px(kRig, {400.0, 100.0}, 30.0) - Eigen::Vector2d(400.0, 100.0)).norm(), 1e-9);
  EXPECT_EQ(RigCorrection::from(off().vector()).vector(), off().vector());
}

TEST(RigChange, LeadsThereAndBack) {
  const RigChange there(kRig, {}, off());
  const RigChange back(kRig, off(), {});
  const Eigen::Vector2d start(700.0, 120.0);
  EXPECT_LT((back.right_px(there.right_px(start, 25.0), 25.0) - start).norm(), 0.01);
  // The raw pixel stays the same.
  EXPECT_LT((off().raw_right_px(kRig, there.right_px(start, 25.0), 25.0) - start).norm(), 0.01);
}

TEST(DepthError, GrowsWithTheSquareOfDepthAndHasASign) {
  RigCorrection right;  // Looks farther right: all points seem nearer.
  right.turn_rad.y() = 0.5 / kRig.fx_px;
  const double at_10_m = depth_error_m(kRig, right, 10.0);
  const double at_20_m = depth_error_m(kRig, right, 20.0);
  EXPECT_LT(at_10_m, 0.0);
  EXPECT_NEAR(at_20_m / at_10_m, 4.0, 0.2);
  EXPECT_NEAR(at_10_m, -0.5 * 100.0 / (kRig.fx_px * kRig.baseline_m), 0.01);
  RigCorrection left;
  left.turn_rad.y() = -20.0 / kRig.fx_px;
  EXPECT_EQ(depth_error_m(kRig, left, 50.0), std::numeric_limits<double>::infinity());
}

TEST(DepthError, IsTheFocalLengthsPartOfTheDepth) {
  RigCorrection longer;
  longer.focal = 0.01;
  EXPECT_NEAR(depth_error_m(kRig, longer, 20.0), -0.2, 0.003);
}

TEST(RigVerdict, HasNames) {
  EXPECT_EQ(to_string(RigVerdict::kUnknown), "unknown");
  EXPECT_EQ(to_string(RigVerdict::kCorrected), "corrected");
}

}  // namespace
}  // namespace kinetrace
