// Measurements of an object's position and motion in one frame, without its reconstruction.
#pragma once

#include <Eigen/Core>

#include "kinetrace/core/se3.hpp"

namespace kinetrace::objects {

/// Centre of the visible part of an object, by stereo.
struct StereoPosition {
  Eigen::Vector3d uvd_px = Eigen::Vector3d::Zero();  ///< Medians of u_left, v and disparity.
  int features = 0;                                  ///< Number of points in the medians.
  /// From that centre to the object's origin, world axes.
  Eigen::Vector3d to_origin_m = Eigen::Vector3d::Zero();
  /// Standard deviation of that centre on the object: over the surface, and by occlusion or truncation (extended
  /// object).
  double extent_sigma_m = 0.0;
};

/// Centre of a mask in the left image.
struct Bearing {
  Eigen::Vector2d uv_px = Eigen::Vector2d::Zero();
  Eigen::Vector3d to_origin_m = Eigen::Vector3d::Zero();
  double extent_sigma_m = 0.0;
};

/// Motion of an object's visible part in the left image since the previous frame. Unlike the centre of the visible
/// part, it does not drift as that part grows or shrinks.
struct ImageMotion {
  Eigen::Vector2d now_px = Eigen::Vector2d::Zero();
  Eigen::Vector2d before_px = Eigen::Vector2d::Zero();
  Eigen::Vector3d to_origin_m = Eigen::Vector3d::Zero();  ///< From the centre of the visible part, as above.
  int features = 0;  ///< Number tracked between the frames; the positions are their medians.
  double interval_s = 0.0;
  Se3 T_world_cam_before;
};

}  // namespace kinetrace::objects
