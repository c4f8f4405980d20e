// Reprojection error: distance between the measured and the projected corner.
#pragma once

#include <Eigen/Core>
#include <ceres/rotation.h>

#include "kinetrace/core/se3.hpp"
#include "kinetrace/hal/rig_calibration.hpp"

namespace kinetrace::calibration {

/// fx fy cx cy, then the eight coefficients of CameraModel: the same functions as CameraModel::project, for any scalar.
template <typename T>
void project(hal::LensModel lens, const T* camera, const T& x, const T& y, T* px) {
  using std::atan;
  using std::sqrt;
  const T* d = camera + 4;
  const T r2 = x * x + y * y;
  T u = x;
  T v = y;
  if (lens == hal::LensModel::kRadialTangential) {
    const T radial = (T(1) + r2 * (d[0] + r2 * (d[1] + r2 * d[4]))) / (T(1) + r2 * (d[5] + r2 * (d[6] + r2 * d[7])));
    u = x * radial + T(2) * d[2] * x * y + d[3] * (r2 + T(2) * x * x);
    v = y * radial + d[2] * (r2 + T(2) * y * y) + T(2) * d[3] * x * y;
  } else if (r2 > T(1e-16)) {
    const T r = sqrt(r2);
    const T theta = atan(r);
    const T t2 = theta * theta;
    const T scale = theta * (T(1) + t2 * (d[0] + t2 * (d[1] + t2 * (d[2] + t2 * d[3])))) / r;
    u = x * scale;
    v = y * scale;
  }
  px[0] = camera[0] * u + camera[2];
  px[1] = camera[1] * v + camera[3];
}

/// left_update(base, xi) * p.
template <typename T>
void transform(const Se3& base, const T* xi, const T* p, T* moved) {
  T rotated[3];
  for (int i = 0; i < 3; ++i) {
    rotated[i] = T(base.translation(i));
    for (int j = 0; j < 3; ++j) {
      rotated[i] += base.rotation(i, j) * p[j];
    }
  }
  ceres::AngleAxisRotatePoint(xi, rotated, moved);
  for (int i = 0; i < 3; ++i) {
    moved[i] += xi[3 + i];
  }
}

/// A corner in one image. Poses are estimated as perturbations of the base poses.
struct ReprojectionCost {
  hal::LensModel lens;
  Eigen::Vector2d measured_px;
  Eigen::Vector3d point_m;
  const Se3* T_left_board;
  const Se3* T_right_left;  ///< Null in the left image.

  template <typename T>
  bool residual(const T* camera, const T* p_cam, T* error) const {
    if (p_cam[2] < T(1e-6)) {
      return false;
    }
    T px[2];
    project(lens, camera, T(p_cam[0] / p_cam[2]), T(p_cam[1] / p_cam[2]), px);
    error[0] = px[0] - measured_px.x();
    error[1] = px[1] - measured_px.y();
    return true;
  }
  /// The left image.
  template <typename T>
  bool operator()(const T* camera, const T* board, T* error) const {
    const T point[3] = {T(point_m.x()), T(point_m.y()), T(point_m.z())};
    T p_left[3];
    transform(*T_left_board, board, point, p_left);
    return residual(camera, p_left, error);
  }
  /// The right image.
  template <typename T>
  bool operator()(const T* camera, const T* board, const T* right, T* error) const {
    const T point[3] = {T(point_m.x()), T(point_m.y()), T(point_m.z())};
    T p_left[3];
    T p_right[3];
    transform(*T_left_board, board, point, p_left);
    transform(*T_right_left, right, p_left, p_right);
    return residual(camera, p_right, error);
  }
};

}  // namespace kinetrace::calibration
