// The right camera's pose from two stereo frames of one scene.
#pragma once

#include <span>

#include <Eigen/Core>

#include "kinetrace/core/rig_correction.hpp"
#include "kinetrace/core/se3.hpp"
#include "kinetrace/core/stereo_geometry.hpp"

namespace kinetrace::rig {

/// A point that stands still, in both images of both frames; right pixels as the camera gives them.
struct TwoViewPoint {
  Eigen::Vector2f left_before_px;
  Eigen::Vector2f right_before_px;
  Eigen::Vector2f left_px;
  Eigen::Vector2f right_px;
};

/// What two frames tell: the correction at the later one, and how it has changed since the earlier one.
struct RigMeasurement {
  static constexpr int kSize = 2 * RigCorrection::kSize;
  using Vector = Eigen::Matrix<double, kSize, 1>;
  using Matrix = Eigen::Matrix<double, kSize, kSize>;

  Vector value = Vector::Zero();
  Matrix covariance = Matrix::Identity();
  int points = 0;  ///< That agree.
  /// Root of the mean square of what is left, over what the noise model promises.
  double misfit = 1.0;
  bool valid = false;
};

/// Bundle adjustment of two frames, points and the right camera's pose, which may differ between the frames. A point's
/// error of matching stays with it from frame to frame, so that it counts once, however often it is seen: what tells of
/// the pose is how depth by stereo and depth by motion differ over points at many depths. `start` are first guesses of
/// the measurement, `T_now_before` of the motion. Robust against points that move by themselves (Cauchy loss). Where
/// the focal length is not `focal_shown`, because the camera has not turned, it stays as in `start`, and the
/// measurement says nothing of it.
[[nodiscard]] RigMeasurement calibrate_two_views(const StereoGeometry& geometry, std::span<const TwoViewPoint> points,
                                                 const Se3& T_now_before, const RigMeasurement::Vector& start,
                                                 bool focal_shown);

}  // namespace kinetrace::rig
