#include "pose_information.hpp"

#include "kinetrace/core/stereo_reprojection.hpp"

namespace kinetrace::batch {

Matrix6d pose_information(const StereoGeometry& geometry, std::span<const Eigen::Vector3d> p_a_m, double sigma_px) {
  const ReprojectionModel<double> model{geometry.fx_px, geometry.fy_px, geometry.cx_px, geometry.cy_px,
                                        geometry.fx_px * geometry.baseline_m};
  Matrix6d information = Matrix6d::Zero();
  for (const Eigen::Vector3d& p : p_a_m) {
    const auto r = stereo_reprojection<double>(model, p.x(), p.y(), p.z(), 0.0, 0.0, 0.0);
    Eigen::Matrix3d d_point;
    d_point << r.du_dx, 0.0, r.du_left_dz, 0.0, r.dv_dy, r.dv_dz, r.du_dx, 0.0, r.du_right_dz;
    Eigen::Matrix<double, 3, 6> jacobian;
    jacobian << -d_point * skew(p), d_point;
    information += jacobian.transpose() * jacobian;
  }
  return information / (2.0 * sigma_px * sigma_px);
}

}  // namespace kinetrace::batch
