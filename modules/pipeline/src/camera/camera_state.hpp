// The camera in one frame, as objects are composed with it.
#pragma once

#include <optional>

#include "kinetrace/core/se3.hpp"

namespace kinetrace::pipeline {

/// What the camera does in this frame, for composing (METHOD eq. 2).
struct CameraState {
  Se3 T_world_cam;
  std::optional<Se3> T_world_cam_before;  ///< Of the frame before, where it had a pose.
  Matrix6d covariance = Matrix6d::Zero();
  double residual_sigma_px = 0.0;  ///< Of the background's measurements.
  /// By how much all disparities may be off, because the calibration may be wrong; standard deviation.
  double disparity_sigma_px = 0.0;
  double background_disparity_px = 0.0;  ///< Median of its features; 0: not known.
  bool valid = false;  ///< A pair of object and background counts only where both have a pose (paper).
};

}  // namespace kinetrace::pipeline
