#include "kinetrace/core/rig_correction.hpp"

#include <Eigen/LU>

#include "kinetrace/core/se3.hpp"

namespace kinetrace {

Eigen::Matrix3d RigCorrection::raw_from_turned(const StereoGeometry& g) const {
  Eigen::Matrix3d K;
  K << g.fx_px, 0.0, g.cx_px, 0.0, g.fy_px, g.cy_px, 0.0, 0.0, 1.0;
  Eigen::Matrix3d K_shifted = K;
  K_shifted(0, 2) -= shift_rad * g.fx_px;
  Eigen::Matrix3d K_inverse;
  K_inverse << 1.0 / g.fx_px, 0.0, -g.cx_px / g.fx_px, 0.0, 1.0 / g.fy_px, -g.cy_px / g.fy_px, 0.0, 0.0, 1.0;
  return K_shifted * so3_exp(-turn_rad) * K_inverse;
}

Eigen::Vector2d RigCorrection::baseline_shift_px(const StereoGeometry& g, const Eigen::Vector2d& right_px,
                                                 double disparity_px) const {
  // With the camera centre lower, points appear higher; with it farther forward, farther from the principal point.
  const double forward = baseline_rad.y() * disparity_px / g.fx_px;
  return {(right_px.x() - g.cx_px) * forward,
          (right_px.y() - g.cy_px) * forward - baseline_rad.x() * disparity_px * g.fy_px / g.fx_px};
}

Eigen::Vector2d RigCorrection::raw_right_px(const StereoGeometry& geometry, const Eigen::Vector2d& right_px,
                                            double disparity_px) const {
  const Eigen::Vector2d turned = right_px + baseline_shift_px(geometry, right_px, disparity_px);
  return (raw_from_turned(geometry) * turned.homogeneous()).hnormalized();
}

RigChange::RigChange(const StereoGeometry& geometry, const RigCorrection& before, const RigCorrection& now)
    : geometry_(geometry),
      before_(before),
      now_(now),
      now_from_before_(now.raw_from_turned(geometry).inverse() * before.raw_from_turned(geometry)) {}

Eigen::Vector2d RigChange::right_px(const Eigen::Vector2d& before_px, double disparity_px) const {
  const Eigen::Vector2d turned = before_px + before_.baseline_shift_px(geometry_, before_px, disparity_px);
  const Eigen::Vector2d now = (now_from_before_ * turned.homogeneous()).hnormalized();
  return now - now_.baseline_shift_px(geometry_, now, disparity_px);
}

std::string_view to_string(RigVerdict verdict) noexcept {
  switch (verdict) {
    case RigVerdict::kHolds: return "holds";
    case RigVerdict::kOff: return "off";
    case RigVerdict::kCorrected: return "corrected";
    case RigVerdict::kUnknown: break;
  }
  return "unknown";
}

double depth_error_m(const StereoGeometry& geometry, const RigCorrection& correction, double depth_m) {
  const Eigen::Vector2d middle(geometry.cx_px, geometry.cy_px);
  const double disparity_px = (1.0 + correction.focal) * geometry.disparity_px(depth_m);
  const double measured_px = disparity_px + middle.x() - correction.raw_right_px(geometry, middle, disparity_px).x();
  return measured_px > 0.0 ? geometry.depth_m(measured_px) - depth_m : std::numeric_limits<double>::infinity();
}

}  // namespace kinetrace
