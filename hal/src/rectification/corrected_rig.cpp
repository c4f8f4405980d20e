// Applies an estimated correction to a calibration.
#include <algorithm>
#include <array>
#include <cmath>

#include "kinetrace/hal/rectifier.hpp"
#include "rectification/rectification_plan.hpp"

namespace kinetrace::hal {
namespace {

/// Changes the focal length without changing the distortion in pixels: coefficients scale with powers of the normalised
/// radius.
CameraModel with_focal(CameraModel lens, double scale) {
  lens.fx_px *= scale;
  lens.fy_px *= scale;
  // k1 k2 p1 p2 k3 k4 k5 k6, in OpenCV's order.
  constexpr std::array<int, 8> kPowers{2, 4, 1, 1, 6, 2, 4, 6};
  if (lens.lens == LensModel::kRadialTangential) {
    for (std::size_t i = 0; i < std::min(lens.distortion.size(), kPowers.size()); ++i) {
      lens.distortion[i] *= std::pow(scale, kPowers[i]);
    }
  }
  return lens;
}

}  // namespace

Result<RigCalibration> corrected_rig(const RigCalibration& calibration, const RectifierConfig& config,
                                     const RigCorrection& correction) {
  const Result<RectificationPlan> plan = plan_rectification(calibration, config);
  if (!plan) {
    return Unexpected(plan.error());
  }
  RigCalibration corrected = to_raw_rig(calibration);
  const Eigen::Vector3d direction(1.0, correction.baseline_rad.x(), correction.baseline_rad.y());
  // Corrects the rotation of the rectified right camera, then undoes the rectification of both views.
  const Eigen::Matrix3d R_right_raw_left_rect = plan->R_right.transpose() * so3_exp(-correction.turn_rad);
  corrected.T_right_left.rotation = R_right_raw_left_rect * plan->R_left;
  corrected.T_right_left.translation = -R_right_raw_left_rect * (plan->geometry.baseline_m * direction.normalized());
  corrected.left = with_focal(corrected.left, 1.0 + correction.focal);
  corrected.right = with_focal(corrected.right, 1.0 + correction.focal);
  corrected.right.cx_px -= correction.shift_rad * corrected.right.fx_px;
  return corrected;
}

}  // namespace kinetrace::hal
