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
  bool valid = false;              ///< A pair of object and background counts only where both have a pose (paper).
};

}  // namespace kinetrace::pipeline
