// The camera in one frame, for composing objects with it.
#pragma once

#include <optional>

#include "kinetrace/core/se3.hpp"

namespace kinetrace::pipeline {

/// Pose of the camera in this frame and its errors, for composing (the paper's eq. 2).
struct CameraState {
  Se3 T_world_cam;
  std::optional<Se3> T_world_cam_before;                   ///< Of the previous frame, if it had a pose.
  std::optional<Eigen::Vector3d> vertical = std::nullopt;  ///< Normal of the ground, world axes, where it is known.
  Matrix6d covariance = Matrix6d::Zero();
  /// Standard deviation of the common error of all disparities, by an uncertain calibration.
  double disparity_sigma_px = 0.0;
  double background_disparity_px = 0.0;  ///< Median of its features; 0: not known.
  bool valid = false;                    ///< An object's pose counts only where the background has one, too (paper).
};

}  // namespace kinetrace::pipeline
