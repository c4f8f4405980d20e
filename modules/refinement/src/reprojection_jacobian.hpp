// The stereo reprojection residual in double precision, whitened, with dense Jacobians.
#pragma once

#include <cmath>

#include <Eigen/Core>

#include "kinetrace/core/bundle.hpp"
#include "kinetrace/core/stereo_reprojection.hpp"
#include "robust_loss.hpp"

namespace kinetrace::refinement {

struct ReprojectionJacobian {
  bool in_front = false;
  Eigen::Vector3d residual = Eigen::Vector3d::Zero();  ///< In sigmas; the third is 0 without a right match.
  Eigen::Matrix3d d_point = Eigen::Matrix3d::Zero();   ///< With respect to the point in the camera frame.
};

/// One observation of a point at `p_cam`. Behind the camera the residual is constant.
[[nodiscard]] inline ReprojectionJacobian reprojection_jacobian(const StereoGeometry& geometry,
                                                                const BundleObservation& seen,
                                                                const Eigen::Vector3d& p_cam) {
  ReprojectionJacobian out;
  out.in_front = p_cam.z() > kMinDepthBaselines * geometry.baseline_m;
  if (!out.in_front) {
    out.residual.x() = kBehindCameraSigmas;
    return out;
  }
  const ReprojectionModel<double> model{geometry.fx_px, geometry.fy_px, geometry.cx_px, geometry.cy_px,
                                        geometry.fx_px * geometry.baseline_m};
  const bool has_right = !std::isnan(seen.u_right_px);
  const StereoReprojection<double> r = stereo_reprojection<double>(
      model, p_cam.x(), p_cam.y(), p_cam.z(), static_cast<double>(seen.u_left_px), static_cast<double>(seen.v_px),
      has_right ? static_cast<double>(seen.u_right_px) : 0.0);
  const auto weight = static_cast<double>(seen.inverse_sigma_px);
  const double right_weight = has_right ? weight : 0.0;
  out.residual << weight * r.residual[0], weight * r.residual[1], right_weight * r.residual[2];
  out.d_point << weight * r.du_dx, 0.0, weight * r.du_left_dz, 0.0, weight * r.dv_dy, weight * r.dv_dz,
      right_weight * r.du_dx, 0.0, right_weight * r.du_right_dz;
  return out;
}

/// d p_cam / d xi for the left perturbation xi of T_cam_body: [ -skew(p_cam), I ].
[[nodiscard]] inline Eigen::Matrix<double, 3, 6> pose_jacobian(const Eigen::Vector3d& p_cam) {
  Eigen::Matrix<double, 3, 6> jacobian;
  jacobian << -skew(p_cam), Eigen::Matrix3d::Identity();
  return jacobian;
}

}  // namespace kinetrace::refinement
