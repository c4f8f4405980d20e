#include <cmath>

#include <Eigen/Geometry>

#include "kinetrace/tracking/prediction.hpp"

namespace kinetrace::tracking {

// A uniform density in the box, convolved with the normal distribution of its faces and of the measurement; both are
// approximated by their moments.
double PredictedVolume::density_at(const Eigen::Vector2d& left_px, double disparity_px,
                                   double disparity_sigma_px) const {
  const auto point_at = [&](double px) -> Eigen::Vector3d {
    return (T_box_stereo * Eigen::Vector4d(left_px.x(), left_px.y(), px, 1.0)).hnormalized();
  };
  const Eigen::Vector3d point_m = point_at(disparity_px);
  const Eigen::Vector3d point_sigma_m = point_at(disparity_px + disparity_sigma_px) - point_m;
  const Eigen::Vector3d outside_m = (point_m.cwiseAbs() - half_size_m).cwiseMax(0.0);
  const Eigen::Vector3d variance_m2 = sigma_m.cwiseAbs2() + point_sigma_m.cwiseAbs2();
  const Eigen::Vector3d extent_m = (half_size_m.cwiseAbs2() + variance_m2).cwiseSqrt();
  return half_size_m.cwiseQuotient(extent_m).prod() *
         std::exp(-0.5 * outside_m.cwiseAbs2().cwiseQuotient(variance_m2).sum());
}

bool PredictedVolume::hides(const Eigen::Vector2d& left_px, double disparity_px) const {
  // The ray from the measured point to the camera, where the disparity is infinite, against the slabs of the box.
  const Eigen::Vector3d point_m =
      (T_box_stereo * Eigen::Vector4d(left_px.x(), left_px.y(), disparity_px, 1.0)).hnormalized();
  const Eigen::Vector3d to_camera_m = T_box_stereo.col(2).hnormalized() - point_m;
  double enters = 0.0;
  double leaves = 1.0;
  for (int axis = 0; axis < 3; ++axis) {
    const double at_low = (-half_size_m[axis] - point_m[axis]) / to_camera_m[axis];
    const double at_high = (half_size_m[axis] - point_m[axis]) / to_camera_m[axis];
    enters = std::max(enters, std::min(at_low, at_high));
    leaves = std::min(leaves, std::max(at_low, at_high));
  }
  return enters < leaves;
}

}  // namespace kinetrace::tracking
