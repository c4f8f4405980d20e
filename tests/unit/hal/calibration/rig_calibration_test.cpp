#include "kinetrace/hal/rig_calibration.hpp"

#include <iterator>
#include <limits>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "rig_for_test.hpp"
#include "util/whole_pixels.hpp"

namespace kinetrace::hal {
namespace {

using ::testing::HasSubstr;

void expect_rejected(RigCalibration rig, const char* what) {
  rig.source = "calib.yaml";
  const Status status = rig.validate();
  ASSERT_FALSE(status) << "expected: " << what;
  EXPECT_EQ(status.error().code, ErrorCode::kBadCalibration);
  EXPECT_THAT(status.error().message, HasSubstr("calib.yaml: "));
  EXPECT_THAT(status.error().message, HasSubstr(what));
  EXPECT_THAT(status.error().message, HasSubstr(";"));
}

TEST(RigCalibration, AcceptsGoodRigs) {
  EXPECT_TRUE(test::radial_rig().validate());
  EXPECT_TRUE(test::fisheye_rig().validate());
  EXPECT_TRUE(test::given_rig().validate());
  EXPECT_TRUE(test::rectified_rig().validate());
}

TEST(RigCalibration, RejectsValuesThatAreNoNumbers) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  for (double CameraModel::*member :
       {&CameraModel::fx_px, &CameraModel::fy_px, &CameraModel::cx_px, &CameraModel::cy_px}) {
    RigCalibration rig = test::radial_rig();
    rig.right.*member = nan;
    expect_rejected(rig, "right");
  }
  RigCalibration rig = test::radial_rig();
  rig.left.distortion[3] = std::numeric_limits<double>::infinity();
  expect_rejected(rig, "left distortion");
  rig = test::radial_rig();
  rig.T_right_left.translation.y() = nan;
  expect_rejected(rig, "baseline is nan");
  rig = test::radial_rig();
  rig.T_right_left.rotation(1, 2) = nan;
  expect_rejected(rig, "no rotation matrix");
  rig = test::given_rig();
  rig.given->P_right(1, 1) = nan;
  expect_rejected(rig, "projection matrix");
  rig = test::rectified_rig();
  rig.rectified->baseline_m = nan;
  expect_rejected(rig, "baseline is nan");
}

TEST(RigCalibration, RejectsDistortionThatNoLensHas) {
  const double absurd[] = {300.0, 1e5, 300.0, 300.0, 1e7};  // k1 k2 p1 p2 k3.
  for (std::size_t i = 0; i < std::size(absurd); ++i) {
    for (const double value : {-absurd[i], absurd[i]}) {
      RigCalibration rig = test::radial_rig();
      rig.left.distortion[i] = value;
      expect_rejected(rig, "left distortion is that of no lens");
    }
  }
  RigCalibration rig = test::fisheye_rig();
  rig.right.distortion[0] = -40.0;
  expect_rejected(rig, "right distortion is that of no lens");
}

TEST(RigCalibration, AcceptsTheDistortionOfStrongLenses) {
  RigCalibration rig = test::radial_rig();
  rig.left.distortion = {-0.45, 0.25, 0.002, -0.002, -0.08, 0.0, 0.0, 0.0};
  EXPECT_TRUE(rig.validate());
  rig.left.distortion = {0.3, 0.1, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0};
  EXPECT_TRUE(rig.validate());
}

TEST(RigCalibration, RejectsSizesThatNoImageHas) {
  RigCalibration rig = test::given_rig();
  rig.given->width_px = rig.given->height_px = std::numeric_limits<int>::max();
  expect_rejected(rig, "rectified image size 2147483647x2147483647 is beyond 16384x16384");
  rig = test::radial_rig();
  rig.left.height_px = 16385;
  expect_rejected(rig, "left image size");
  rig = test::rectified_rig();
  rig.rectified->width_px = 16385;
  expect_rejected(rig, "rectified image size");
}

TEST(WholePixels, FitsEveryNumberIntoAnInteger) {
  EXPECT_EQ(whole_pixels(639.7), 640);
  EXPECT_EQ(whole_pixels(1e300), std::numeric_limits<int>::max());
  EXPECT_EQ(whole_pixels(-1.0), 0);
  EXPECT_EQ(whole_pixels(std::nan("")), 0);
}

TEST(RigCalibration, RejectsImpossibleIntrinsics) {
  RigCalibration rig = test::radial_rig();
  rig.left.fx_px = 0;
  expect_rejected(rig, "left focal length fx must be a positive number, got 0");
  rig = test::radial_rig();
  rig.right.fy_px = -457;
  expect_rejected(rig, "got -457");
  rig = test::radial_rig();
  rig.left.fx_px = 4;
  expect_rejected(rig, "left focal length fx = 4 px is that of no lens for images of 752 px; give it in pixels");
  rig.left.fx_px = 1e9;
  expect_rejected(rig, "is that of no lens");
  rig.left.fx_px = 0.02 * 752;
  rig.left.distortion = {};
  EXPECT_TRUE(rig.validate());
  rig = test::radial_rig();
  rig.left.cx_px = 1129;
  expect_rejected(rig, "far outside the image of 752 px");
  rig.left.cx_px = 1128;
  EXPECT_TRUE(rig.validate());
  rig = test::radial_rig();
  rig.left.height_px = 0;
  expect_rejected(rig, "image size is missing");
}

TEST(RigCalibration, RejectsCamerasOfDifferentSizes) {
  RigCalibration rig = test::radial_rig();
  rig.right.width_px = 640;
  expect_rejected(rig, "left 752x480, right 640x480");
}

TEST(RigCalibration, SaysThatLeftAndRightLookSwapped) {
  RigCalibration rig = test::radial_rig();
  std::swap(rig.left, rig.right);
  rig.T_right_left = rig.T_right_left.inverse();
  expect_rejected(rig, "left and right look swapped");

  rig = test::given_rig();
  std::swap(rig.given->P_left, rig.given->P_right);
  expect_rejected(rig, "left and right look swapped");

  rig = test::rectified_rig();
  rig.rectified->baseline_m = -0.5;
  expect_rejected(rig, "left and right look swapped");
}

TEST(RigCalibration, RejectsAMissingBaseline) {
  RigCalibration rig = test::radial_rig();
  rig.T_right_left.translation.setZero();
  expect_rejected(rig, "missing or zero");
  rig = test::given_rig();
  rig.given->P_right(0, 3) = 0;
  expect_rejected(rig, "missing or zero");
  rig = test::rectified_rig();
  rig.rectified->baseline_m = 0;
  expect_rejected(rig, "missing or zero");
}

TEST(RigCalibration, RejectsCamerasAboveEachOther) {
  RigCalibration rig = test::radial_rig();
  rig.T_right_left.translation = {0, -0.11, 0};
  expect_rejected(rig, "not horizontal");
  rig = test::given_rig();
  rig.given->P_right(1, 3) = rig.given->P_right(0, 3);
  expect_rejected(rig, "not horizontal");
}

TEST(RigCalibration, SuspectsMillimetres) {
  RigCalibration rig = test::radial_rig();
  rig.T_right_left.translation *= 1000;
  expect_rejected(rig, "millimetres");
}

TEST(RigCalibration, RejectsCamerasThatLookApart) {
  RigCalibration rig = test::radial_rig();
  rig.T_right_left.rotation = so3_exp({0, 1.0, 0});
  expect_rejected(rig, "different directions");
}

TEST(RigCalibration, RepairsRotationsWrittenWithFewDigits) {
  RigCalibration rig = test::radial_rig();
  const Eigen::Matrix3d exact = rig.T_right_left.rotation;
  rig.T_right_left.rotation = (exact * 1000).array().round().matrix() / 1000;
  ASSERT_GT((rig.T_right_left.rotation.transpose() * rig.T_right_left.rotation - Eigen::Matrix3d::Identity()).norm(),
            1e-5);
  ASSERT_TRUE(rig.validate());
  const Eigen::Matrix3d& repaired = rig.T_right_left.rotation;
  EXPECT_LT((repaired.transpose() * repaired - Eigen::Matrix3d::Identity()).norm(), 1e-12);
  EXPECT_LT((repaired - exact).cwiseAbs().maxCoeff(), 1e-3);
}

TEST(RigCalibration, RejectsWhatIsNoRotation) {
  RigCalibration rig = test::radial_rig();
  rig.T_right_left.rotation *= 1.01;
  expect_rejected(rig, "no rotation matrix");
  rig = test::radial_rig();
  rig.T_right_left.rotation.col(1) *= -1;
  expect_rejected(rig, "no rotation matrix");
  rig = test::given_rig();
  rig.given->R_left.setZero();
  expect_rejected(rig, "left rectifying rotation");
}

TEST(GeometryFromProjections, TakesTheDifferenceOfTheCentres) {
  // Cameras 2 and 3 of KITTI have offsets of their own, also in depth: u = (f X + cx Z + P03) / (Z + P23).
  Eigen::Matrix<double, 3, 4> P2;
  Eigen::Matrix<double, 3, 4> P3;
  P2 << 700, 0, 600, 700 * 0.06 + 600 * 0.003, 0, 700, 180, 180 * 0.003, 0, 0, 1, 0.003;
  P3 << 700, 0, 600, 700 * -0.47 + 600 * 0.004, 0, 700, 180, 180 * 0.004, 0, 0, 1, 0.004;
  const auto geometry = geometry_from_projections(P2, P3, 1242, 375, "calib.txt");
  ASSERT_TRUE(geometry) << geometry.error().message;
  EXPECT_NEAR(geometry->baseline_m, 0.53, 1e-12);
  EXPECT_EQ(geometry->cx_px, 600);
}

TEST(GeometryFromProjections, RejectsDifferentCameras) {
  Eigen::Matrix<double, 3, 4> P;
  P << 700, 0, 600, 0, 0, 700, 180, 0, 0, 0, 1, 0;
  Eigen::Matrix<double, 3, 4> other = P;
  other(0, 3) = -350;
  other(0, 2) = 610;
  const auto geometry = geometry_from_projections(P, other, 1242, 375, "calib.txt");
  ASSERT_FALSE(geometry);
  EXPECT_EQ(geometry.error().code, ErrorCode::kBadCalibration);
  EXPECT_THAT(geometry.error().message, HasSubstr("differ by 10 px"));
}

TEST(CameraModel, ProjectsThroughThePinhole) {
  const CameraModel camera{.fx_px = 100, .fy_px = 110, .cx_px = 50, .cy_px = 40};
  EXPECT_TRUE(camera.project({1, -1, 2}).isApprox(Eigen::Vector2d(100, -15)));
}

TEST(CameraModel, EquidistantLensMapsAnglesToRadii) {
  const CameraModel camera{.lens = LensModel::kEquidistant, .fx_px = 100, .fy_px = 100, .cx_px = 0, .cy_px = 0};
  const double angle = 1.2;
  EXPECT_NEAR(camera.project({std::tan(angle), 0, 1}).x(), 120, 1e-9);
  EXPECT_TRUE(camera.project({0, 0, 1}).isZero());
}

TEST(CameraModel, RadialTangentialLensFollowsBrown) {
  CameraModel camera{.fx_px = 1, .fy_px = 1, .distortion = {0.1, 0.01, 0.002, 0.003, 0.001}};
  const double x = 0.3;
  const double y = -0.2;
  const double r2 = x * x + y * y;
  const double radial = 1 + 0.1 * r2 + 0.01 * r2 * r2 + 0.001 * r2 * r2 * r2;
  const Eigen::Vector2d expected(x * radial + 2 * 0.002 * x * y + 0.003 * (r2 + 2 * x * x),
                                 y * radial + 0.002 * (r2 + 2 * y * y) + 2 * 0.003 * x * y);
  EXPECT_TRUE(camera.project({x, y, 1}).isApprox(expected, 1e-14));
}

}  // namespace
}  // namespace kinetrace::hal
