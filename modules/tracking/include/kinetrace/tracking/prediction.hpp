// Predicted image position of an object, from its trajectory.
#pragma once

#include <Eigen/Core>

namespace kinetrace::tracking {

/// A fixed point of an object, projected into the left image of the current frame by the predicted poses of object and
/// camera.
struct ObjectPrediction {
  bool known = false;
  Eigen::Vector2d point_px = Eigen::Vector2d::Zero();  ///< May lie outside the image.
  double depth_m = 0.0;                                ///< Not positive: behind the camera.
  /// Only the direction of a distant object is known; `depth_m` is nominal, very far.
  bool direction_only = false;
  double disparity_px = 0.0;  ///< Of the centre of its visible part; 0: not known.
  double disparity_sigma_px = 0.0;
};

}  // namespace kinetrace::tracking
