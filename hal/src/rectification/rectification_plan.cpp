#include "rectification/rectification_plan.hpp"

#include <opencv2/calib3d.hpp>

#include "calibration/opencv_lens.hpp"
#include "kinetrace/core/allocation_counter.hpp"
#include "util/messages.hpp"

namespace kinetrace::hal {
namespace {

void plan_from_given(RectificationPlan& plan) {
  const RectifyingTransforms& given = *plan.calibration.given;
  plan.R_left = given.R_left;
  plan.R_right = given.R_right;
  // Cannot fail: the calibration is valid.
  plan.geometry =
      geometry_from_projections(given.P_left, given.P_right, given.width_px, given.height_px, plan.calibration.source)
          .value();
}

// Bouguet's method: each view takes half of the relative rotation, then both are rotated until the baseline is their x
// axis.
void plan_from_rig(RectificationPlan& plan, double keep_borders) {
  const RigCalibration& rig = plan.calibration;
  const cv::Matx33d K_left = camera_matrix(rig.left);
  const cv::Matx33d K_right = camera_matrix(rig.right);
  const cv::Matx33d R = to_opencv(rig.T_right_left.rotation);
  const Eigen::Vector3d& t = rig.T_right_left.translation;
  const cv::Vec3d translation(t.x(), t.y(), t.z());
  const cv::Size size(rig.left.width_px, rig.left.height_px);
  cv::Matx33d R_left;
  cv::Matx33d R_right;
  cv::Matx34d P_left;
  cv::Matx34d P_right;
  cv::Matx44d Q;
  if (rig.left.lens == LensModel::kEquidistant) {
    cv::fisheye::stereoRectify(K_left, distortion_vector(rig.left), K_right, distortion_vector(rig.right), size, R,
                               translation, R_left, R_right, P_left, P_right, Q, cv::CALIB_ZERO_DISPARITY, size,
                               keep_borders);
  } else {
    cv::stereoRectify(K_left, distortion_vector(rig.left), K_right, distortion_vector(rig.right), size, R, translation,
                      R_left, R_right, P_left, P_right, Q, cv::CALIB_ZERO_DISPARITY, keep_borders, size);
  }
  plan.R_left = to_eigen(R_left);
  plan.R_right = to_eigen(R_right);
  plan.geometry = {.fx_px = P_left(0, 0),
                   .fy_px = P_left(1, 1),
                   .cx_px = P_left(0, 2),
                   .cy_px = P_left(1, 2),
                   .baseline_m = -P_right(0, 3) / P_right(0, 0),
                   .width_px = size.width,
                   .height_px = size.height};
}

bool is_pinhole_of(const CameraModel& camera, const Eigen::Matrix3d& R, const StereoGeometry& geometry) {
  constexpr double kTolerance_px = 1e-3;
  const bool undistorted =
      camera.lens == LensModel::kRadialTangential &&
      std::all_of(camera.distortion.begin(), camera.distortion.end(), [](double d) { return d == 0.0; });
  const double intrinsics_px =
      std::max({std::abs(camera.fx_px - geometry.fx_px), std::abs(camera.fy_px - geometry.fy_px),
                std::abs(camera.cx_px - geometry.cx_px), std::abs(camera.cy_px - geometry.cy_px)});
  return undistorted && intrinsics_px < kTolerance_px && R.isIdentity(kTolerance_px / geometry.fx_px) &&
         camera.width_px == geometry.width_px && camera.height_px == geometry.height_px;
}

// A computed rectification can degenerate where the lens model is not monotonic.
Status check_result(const RectificationPlan& plan) {
  RigCalibration result;
  result.source = plan.calibration.source;
  result.rectified = plan.geometry;
  const Status status = result.validate();
  if (!status) {
    return fail(ErrorCode::kBadCalibration, status.error().message + " (computed by rectifying; check the distortion)");
  }
  return {};
}

}  // namespace

Result<RectificationPlan> plan_rectification(const RigCalibration& calibration, const RectifierConfig& config) {
  RectificationPlan plan;
  plan.calibration = calibration;
  if (const Status valid = config.validate(); !valid) {
    return Unexpected(valid.error());
  }
  if (const Status valid = plan.calibration.validate(); !valid) {
    return Unexpected(valid.error());
  }
  if (calibration.rectified) {
    plan.geometry = *calibration.rectified;
    plan.passes_through = true;
    return plan;
  }
  if (!calibration.given && calibration.left.lens != calibration.right.lens) {
    return fail(ErrorCode::kUnsupported,
                calibration.source + ": the views have different lens models; use one for both");
  }
  if (calibration.given) {
    plan_from_given(plan);
  } else {
    const ForeignCall foreign;
    try {
      plan_from_rig(plan, config.keep_borders);
    } catch (const cv::Exception& exception) {
      return fail(ErrorCode::kBadCalibration,
                  calibration.source + ": cannot be rectified (OpenCV: " + exception.err + "); calibrate again");
    }
  }
  if (const Status sound = check_result(plan); !sound) {
    return Unexpected(sound.error());
  }
  plan.passes_through = is_pinhole_of(plan.calibration.left, plan.R_left, plan.geometry) &&
                        is_pinhole_of(plan.calibration.right, plan.R_right, plan.geometry);
  return plan;
}

}  // namespace kinetrace::hal
