// The right camera's pose from two stereo frames of one scene.
#pragma once

#include <span>

#include <Eigen/Core>

#include "kinetrace/core/rig_correction.hpp"
#include "kinetrace/core/se3.hpp"
#include "kinetrace/core/stereo_geometry.hpp"

namespace kinetrace::rig {

/// A static point in both images of both frames; right pixels as captured.
struct TwoViewPoint {
  Eigen::Vector2f left_before_px;
  Eigen::Vector2f right_before_px;
  Eigen::Vector2f left_px;
  Eigen::Vector2f right_px;
};

/// Result of two frames: the correction at the later one, and its change since the earlier one.
struct RigMeasurement {
  static constexpr int kSize = 2 * RigCorrection::kSize;
  using Vector = Eigen::Matrix<double, kSize, 1>;
  using Matrix = Eigen::Matrix<double, kSize, kSize>;

  Vector value = Vector::Zero();
  Matrix covariance = Matrix::Identity();
  int points = 0;  ///< Inliers.
  /// RMS residual over that of the noise model.
  double rms_ratio = 1.0;
  bool valid = false;
};

/// Bundle adjustment of two frames: points and the right camera's pose, which may differ between the frames. A point's
/// matching error persists between frames (random effect), so that it counts once however often it is observed; the
/// pose follows from the difference of depth by stereo and depth by motion over points at many depths. Initial values:
/// `start` of the measurement, `T_now_before` of the motion. Robust against moving points (Cauchy loss). Unless
/// `focal_shown` (the camera has turned), the focal length stays as in `start`, and the measurement has no information
/// on it.
[[nodiscard]] RigMeasurement calibrate_two_views(const StereoGeometry& geometry, std::span<const TwoViewPoint> points,
                                                 const Se3& T_now_before, const RigMeasurement::Vector& start,
                                                 bool focal_shown);

}  // namespace kinetrace::rig
