// What the trajectory of an object says about where it will be seen.
#pragma once

#include <Eigen/Core>

namespace kinetrace::tracking {

/// One point of an object, always the same, in the left image of the current frame, from where the object and the
/// camera are expected to be.
struct ObjectPrediction {
  bool known = false;
  Eigen::Vector2d point_px = Eigen::Vector2d::Zero();  ///< May lie outside the image.
  double depth_m = 0.0;                                ///< Not positive: behind the camera.
  /// The object is so far away that only its direction is known; `depth_m` stands for very far.
  bool direction_only = false;
  double disparity_px = 0.0;  ///< Of the middle of what is seen of it; 0: not known.
  double disparity_sigma_px = 0.0;
};

}  // namespace kinetrace::tracking
