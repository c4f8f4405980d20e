// Measurements of an object's position and motion in one frame, without its reconstruction.
#pragma once

#include <Eigen/Core>

#include "kinetrace/core/se3.hpp"

namespace kinetrace::objects {

/// Where on an object the centre of its visible part lies, world axes.
struct VisiblePart {
  Eigen::Vector3d to_origin_m = Eigen::Vector3d::Zero();  ///< From that centre to the object's origin.
  /// Covariance of that centre on the object: over the surface, by occlusion or truncation (extended object), and of
  /// its depth.
  Eigen::Matrix3d covariance_m2 = Eigen::Matrix3d::Zero();
};

/// Centre of the visible part of an object, by stereo.
struct StereoPosition {
  Eigen::Vector3d uvd_px = Eigen::Vector3d::Zero();  ///< Medians of u_left, v and disparity.
  int features = 0;                                  ///< Number of points in the medians.
  VisiblePart part;
};

/// Centre of a mask in the left image.
struct Bearing {
  Eigen::Vector2d uv_px = Eigen::Vector2d::Zero();
  double center_sigma_m = 0.0;  ///< Of that centre from the visible part's, standard deviation.
  VisiblePart part;
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
