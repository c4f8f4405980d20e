#include "rig_for_test.hpp"

#include "kinetrace/core/se3.hpp"

namespace kinetrace::hal::test {
namespace {

// Right view at `offset` in the left view's frame, turned by `turn_rad`.
Se3 right_from_left(const Eigen::Vector3d& offset, const Eigen::Vector3d& turn_rad) {
  const Eigen::Matrix3d R = so3_exp(turn_rad);
  return {R, -(R * offset)};
}

// Fusiello, Trucco, Verri, "A compact algorithm for rectification of stereo pairs", 2000: x along the baseline, y
// across it and the old optical axis.
Eigen::Matrix3d rectifying_rotation(const Se3& T_right_left) {
  const Eigen::Vector3d x = T_right_left.inverse().translation.normalized();
  const Eigen::Vector3d y = Eigen::Vector3d::UnitZ().cross(x).normalized();
  Eigen::Matrix3d R;
  R << x.transpose(), y.transpose(), x.cross(y).transpose();
  return R;
}

}  // namespace

RigCalibration radial_rig() {
  RigCalibration rig;
  rig.source = "radial rig";
  rig.left = {.width_px = 752,
              .height_px = 480,
              .fx_px = 458.7,
              .fy_px = 457.3,
              .cx_px = 367.2,
              .cy_px = 248.4,
              .distortion = {-0.283, 0.074, 0.0002, 0.00002}};
  rig.right = {.width_px = 752,
               .height_px = 480,
               .fx_px = 457.6,
               .fy_px = 456.1,
               .cx_px = 380.0,
               .cy_px = 255.2,
               .distortion = {-0.284, 0.0745, -0.0001, -0.00004}};
  rig.T_right_left = right_from_left({0.11, 0.0004, -0.0006}, {0.002, -0.014, 0.007});
  return rig;
}

RigCalibration fisheye_rig() {
  RigCalibration rig;
  rig.source = "fisheye rig";
  rig.left = {.lens = LensModel::kEquidistant,
              .width_px = 640,
              .height_px = 480,
              .fx_px = 250.0,
              .fy_px = 251.0,
              .cx_px = 322.5,
              .cy_px = 238.0,
              .distortion = {0.012, -0.008, 0.003, -0.0006}};
  rig.right = {.lens = LensModel::kEquidistant,
               .width_px = 640,
               .height_px = 480,
               .fx_px = 252.0,
               .fy_px = 252.5,
               .cx_px = 316.0,
               .cy_px = 243.0,
               .distortion = {0.010, -0.006, 0.002, -0.0004}};
  rig.T_right_left = right_from_left({0.10, -0.001, 0.002}, {0.01, 0.012, -0.008});
  return rig;
}

RigCalibration given_rig() {
  RigCalibration rig;
  rig.source = "given rig";
  rig.left = {.width_px = 696,
              .height_px = 256,
              .fx_px = 492.1,
              .fy_px = 490.4,
              .cx_px = 345.0,
              .cy_px = 116.6,
              .distortion = {-0.373, 0.204, 0.0022, 0.0014, -0.072}};
  rig.right = {.width_px = 696,
               .height_px = 256,
               .fx_px = 494.8,
               .fy_px = 493.9,
               .cx_px = 351.0,
               .cy_px = 122.8,
               .distortion = {-0.364, 0.179, 0.0011, -0.0006, -0.053}};
  rig.T_right_left = right_from_left({0.537, 0.008, -0.005}, {0.009, -0.031, -0.019});
  RectifyingTransforms given;
  given.R_left = rectifying_rotation(rig.T_right_left);
  given.R_right = given.R_left * rig.T_right_left.rotation.transpose();
  given.P_left << 360.8, 0, 304.8, 0, 0, 360.8, 86.4, 0, 0, 0, 1, 0;
  given.P_right = given.P_left;
  given.P_right(0, 3) = -360.8 * rig.T_right_left.translation.norm();
  given.width_px = 620;
  given.height_px = 188;
  rig.given = given;
  return rig;
}

RigCalibration rectified_rig() {
  RigCalibration rig;
  rig.source = "rectified rig";
  rig.rectified = StereoGeometry{
      .fx_px = 40, .fy_px = 40, .cx_px = 24, .cy_px = 16, .baseline_m = 0.5, .width_px = 48, .height_px = 32};
  return rig;
}

}  // namespace kinetrace::hal::test
