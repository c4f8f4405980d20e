// The rectified stereo rig: one focal length pair, one principal point, one baseline.
#pragma once

#include <limits>

#include <Eigen/Core>

namespace kinetrace {

/// Geometry of a rectified pair. A point p (camera frame of the left view: x right, y down, z forward, metres) is seen
/// at u_left = fx x/z + cx, v = fy y/z + cy in the left image and u_right = u_left - fx baseline / z in the right one.
struct StereoGeometry {
  double fx_px = 0.0;
  double fy_px = 0.0;
  double cx_px = 0.0;
  double cy_px = 0.0;
  double baseline_m = 0.0;
  int width_px = 0;
  int height_px = 0;

  [[nodiscard]] double depth_m(double disparity_px) const noexcept { return fx_px * baseline_m / disparity_px; }
  [[nodiscard]] double disparity_px(double depth_m) const noexcept { return fx_px * baseline_m / depth_m; }
  /// Standard deviation of the depth, given that of the disparity.
  [[nodiscard]] double depth_sigma_m(double depth_m, double disparity_sigma_px) const noexcept {
    return disparity_sigma_px * depth_m * depth_m / (fx_px * baseline_m);
  }

  /// Camera-frame point of a stereo observation; `disparity_px` > 0.
  [[nodiscard]] Eigen::Vector3d triangulate(double u_left_px, double v_px, double disparity_px) const noexcept {
    const double z = depth_m(disparity_px);
    return {(u_left_px - cx_px) / fx_px * z, (v_px - cy_px) / fy_px * z, z};
  }
  /// (u_left, v, u_right) of a camera-frame point with z > 0.
  [[nodiscard]] Eigen::Vector3d project(const Eigen::Vector3d& p_cam) const noexcept {
    const double u_left = fx_px * p_cam.x() / p_cam.z() + cx_px;
    const double v = fy_px * p_cam.y() / p_cam.z() + cy_px;
    return {u_left, v, u_left - fx_px * baseline_m / p_cam.z()};
  }
};

/// Points nearer to the camera have no usable projection.
inline constexpr double kMinProjectionDepth_m = 0.1;
/// Correlation time of the errors of an object's stereo measurements.
inline constexpr double kErrorCorrelation_s = 0.5;

/// Value of u_right where a point has no right match.
inline constexpr float kNoRight = std::numeric_limits<float>::quiet_NaN();

}  // namespace kinetrace
