#include <cmath>

#include "kinetrace/hal/rig_calibration.hpp"

namespace kinetrace::hal {
namespace {

// Brown, "Decentering distortion of lenses", 1966, in the coefficient order of OpenCV; k4..k6 are its rational
// extension.
Eigen::Vector2d distort_radial_tangential(const Eigen::Vector2d& m, const std::array<double, 8>& d) {
  const double x = m.x();
  const double y = m.y();
  const double r2 = x * x + y * y;
  const double radial = (1 + r2 * (d[0] + r2 * (d[1] + r2 * d[4]))) / (1 + r2 * (d[5] + r2 * (d[6] + r2 * d[7])));
  return {x * radial + 2 * d[2] * x * y + d[3] * (r2 + 2 * x * x),
          y * radial + d[2] * (r2 + 2 * y * y) + 2 * d[3] * x * y};
}

// Kannala and Brandt, "A generic camera model and calibration method for conventional, wide-angle, and fisheye lenses",
// PAMI 2006, eq. 6 with the coefficient of theta fixed to one.
Eigen::Vector2d distort_equidistant(const Eigen::Vector2d& m, const std::array<double, 8>& d) {
  const double r = m.norm();
  if (r < 1e-12) {
    return m;
  }
  const double theta = std::atan(r);
  const double t2 = theta * theta;
  const double distorted = theta * (1 + t2 * (d[0] + t2 * (d[1] + t2 * (d[2] + t2 * d[3]))));
  return m * (distorted / r);
}

}  // namespace

Eigen::Vector2d CameraModel::project(const Eigen::Vector3d& p_cam) const {
  const Eigen::Vector2d m = p_cam.head<2>() / p_cam.z();
  const Eigen::Vector2d distorted =
      lens == LensModel::kEquidistant ? distort_equidistant(m, distortion) : distort_radial_tangential(m, distortion);
  return {fx_px * distorted.x() + cx_px, fy_px * distorted.y() + cy_px};
}

}  // namespace kinetrace::hal
