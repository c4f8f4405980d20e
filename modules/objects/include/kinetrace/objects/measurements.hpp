// What a frame says about where an object is and how it moves, without a reconstruction of it.
#pragma once

#include <Eigen/Core>

#include "kinetrace/core/se3.hpp"

namespace kinetrace::objects {

/// The middle of what stereo sees of an object.
struct StereoPosition {
  Eigen::Vector3d uvd_px = Eigen::Vector3d::Zero();  ///< Medians of u_left, v and disparity.
  int features = 0;                                  ///< They are medians of so many points.
  /// From that middle to the object's origin, world axes.
  Eigen::Vector3d to_origin_m = Eigen::Vector3d::Zero();
  /// How far what is seen may lie from there: over the surface, and by what is hidden or cut off (extended object).
  double extent_sigma_m = 0.0;
};

/// The middle of a mask in the left image.
struct Bearing {
  Eigen::Vector2d uv_px = Eigen::Vector2d::Zero();
  Eigen::Vector3d to_origin_m = Eigen::Vector3d::Zero();
  double extent_sigma_m = 0.0;
};

/// How what is seen of an object has moved in the left image since the frame before. Unlike the middle of what is seen,
/// it does not drift as more or less of the object comes into sight.
struct ImageMotion {
  Eigen::Vector2d now_px = Eigen::Vector2d::Zero();
  Eigen::Vector2d before_px = Eigen::Vector2d::Zero();
  Eigen::Vector3d to_origin_m = Eigen::Vector3d::Zero();  ///< From the middle of what is seen, as above.
  int features = 0;  ///< That were tracked from frame to frame; these are their medians.
  double interval_s = 0.0;
  Se3 T_world_cam_before;
};

}  // namespace kinetrace::objects
