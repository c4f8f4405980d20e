// A calibration that holds what was found out about it.
#include "kinetrace/hal/rectifier.hpp"
#include "rectification/rectification_plan.hpp"

namespace kinetrace::hal {

Result<RigCalibration> corrected_rig(const RigCalibration& calibration, const RectifierConfig& config,
                                     const RigCorrection& correction) {
  const Result<RectificationPlan> plan = plan_rectification(calibration, config);
  if (!plan) {
    return Unexpected(plan.error());
  }
  RigCalibration corrected = to_raw_rig(calibration);
  const Eigen::Vector3d direction(1.0, correction.baseline_rad.x(), correction.baseline_rad.y());
  // As the rectified right camera really stands, and from there back through the rectification of both.
  const Eigen::Matrix3d R_raw_promised = plan->R_right.transpose() * so3_exp(-correction.turn_rad);
  corrected.T_right_left.rotation = R_raw_promised * plan->R_left;
  corrected.T_right_left.translation = -R_raw_promised * (plan->geometry.baseline_m * direction.normalized());
  corrected.right.cx_px -= correction.shift_rad * corrected.right.fx_px;
  return corrected;
}

}  // namespace kinetrace::hal
