// A run's correction of a calibration, as the calibration of the next run.
#include <vector>

#include <gtest/gtest.h>
#include <opencv2/calib3d.hpp>

#include "calibration/opencv_lens.hpp"
#include "kinetrace/core/se3.hpp"
#include "kinetrace/hal/rectifier.hpp"
#include "rectification/rectification_plan.hpp"

namespace kinetrace::hal {
namespace {

constexpr double kDegree_rad = 0.017453292519943295;

CameraModel lens(double fx_px, double cx_px, double k1) {
  CameraModel camera;
  camera.width_px = 752;
  camera.height_px = 480;
  camera.fx_px = camera.fy_px = fx_px;
  camera.cx_px = cx_px;
  camera.cy_px = 241.0;
  camera.distortion = {k1, 0.05, 0.001, -0.0005};
  return camera;
}

RigCalibration raw_rig() {
  RigCalibration rig;
  rig.source = "rig.yaml";
  rig.left = lens(458.0, 367.0, -0.28);
  rig.right = lens(457.0, 379.0, -0.27);
  rig.T_right_left = {so3_exp({0.004, -0.01, 0.006}), {-0.11, 0.0004, -0.0008}};
  return rig;
}

Eigen::Vector2d rectified_px(const CameraModel& camera, const Eigen::Matrix3d& R, const StereoGeometry& g,
                             const Eigen::Vector2d& raw_px) {
  const std::vector<cv::Point2d> raw{{raw_px.x(), raw_px.y()}};
  std::vector<cv::Point2d> rectified;
  const cv::Matx33d K(g.fx_px, 0, g.cx_px, 0, g.fy_px, g.cy_px, 0, 0, 1);
  cv::undistortPoints(raw, rectified, camera_matrix(camera), distortion_vector(camera), to_opencv(R), K);
  return {rectified[0].x, rectified[0].y};
}

// Raw images of a rig whose true pose differs from `assumed`: with the corrected calibration every point lies in one
// row, at its depth.
void expect_rows_and_depths(const RigCalibration& assumed, const RigCorrection& truth, double tolerance_px) {
  const RectificationPlan before = plan_rectification(assumed, {}).value();
  const Result<RigCalibration> corrected = corrected_rig(assumed, {}, truth);
  ASSERT_TRUE(corrected);
  const RectificationPlan now = plan_rectification(*corrected, {}).value();
  EXPECT_NEAR(now.geometry.baseline_m, before.geometry.baseline_m, 1e-9);
  const RigCalibration raw = to_raw_rig(assumed);
  CameraModel right = raw.right;
  right.cx_px -= truth.shift_rad * right.fx_px;
  const Eigen::Vector3d direction(1.0, truth.baseline_rad.x(), truth.baseline_rad.y());
  for (const Eigen::Vector3d& p_left : {Eigen::Vector3d(0.0, 0.0, 5.0), Eigen::Vector3d(2.0, -0.8, 6.0),
                                        Eigen::Vector3d(-1.5, 1.0, 4.0), Eigen::Vector3d(4.0, 1.0, 15.0)}) {
    const Eigen::Vector3d p_rectified = before.R_left * p_left;
    const Eigen::Vector3d p_right =
        so3_exp(-truth.turn_rad) * (p_rectified - before.geometry.baseline_m * direction.normalized());
    const Eigen::Vector2d left = rectified_px(raw.left, now.R_left, now.geometry, raw.left.project(p_left));
    const Eigen::Vector2d seen =
        rectified_px(corrected->right, now.R_right, now.geometry, right.project(before.R_right.transpose() * p_right));
    EXPECT_NEAR(left.y(), seen.y(), tolerance_px);
    EXPECT_NEAR(left.x() - seen.x(), now.geometry.disparity_px((now.R_left * p_left).z()), tolerance_px);
  }
}

RigCorrection off() {
  return {kDegree_rad * Eigen::Vector3d(0.3, -0.4, 0.2), kDegree_rad * Eigen::Vector2d(0.3, -0.2), 0.04 * kDegree_rad,
          0.0};
}

TEST(CorrectedRig, RawImagesFitIt) {
  expect_rows_and_depths(raw_rig(), off(), 0.02);
}

TEST(CorrectedRig, RectifiedImagesFitItToo) {
  RigCalibration rig;
  rig.source = "rectified";
  rig.rectified = StereoGeometry{.fx_px = 721.0,
                                 .fy_px = 721.0,
                                 .cx_px = 609.0,
                                 .cy_px = 173.0,
                                 .baseline_m = 0.54,
                                 .width_px = 1242,
                                 .height_px = 375};
  expect_rows_and_depths(rig, off(), 0.02);
}

TEST(CorrectedRig, AnotherFocalLengthSeesTheSameRaysDeeper) {
  RigCorrection longer;
  longer.focal = 0.01;
  const RigCalibration before = raw_rig();
  const RigCalibration now = corrected_rig(before, {}, longer).value();
  EXPECT_NEAR(now.left.fx_px, 1.01 * before.left.fx_px, 1e-9);
  // The same pixel: the lens undistorts it to the same place of the image.
  const Eigen::Vector3d p(1.5, -0.8, 4.0);
  const Eigen::Vector3d deeper = p + Eigen::Vector3d(0.0, 0.0, 0.01 * p.z());
  EXPECT_LT((now.left.project(deeper) - before.left.project(p)).norm(), 1e-6);
  EXPECT_LT((now.right.project(deeper) - before.right.project(p)).norm(), 1e-6);
}

TEST(CorrectedRig, NothingToCorrectIsTheSameRig) {
  const RigCalibration rig = raw_rig();
  const Result<RigCalibration> same = corrected_rig(rig, {}, {});
  ASSERT_TRUE(same);
  EXPECT_TRUE(same->T_right_left.rotation.isApprox(rig.T_right_left.rotation, 1e-9));
  EXPECT_TRUE(same->T_right_left.translation.isApprox(rig.T_right_left.translation, 1e-9));
}

TEST(CorrectedRig, ABadCalibrationIsRefused) {
  RigCalibration rig = raw_rig();
  rig.T_right_left.translation.setZero();
  const Result<RigCalibration> corrected = corrected_rig(rig, {}, {});
  ASSERT_FALSE(corrected);
  EXPECT_EQ(corrected.error().code, ErrorCode::kBadCalibration);
}

}  // namespace
}  // namespace kinetrace::hal
