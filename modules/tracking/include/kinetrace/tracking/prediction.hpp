// Predicted image position of an object, from its trajectory.
#pragma once

#include <optional>

#include <Eigen/Core>

namespace kinetrace::tracking {

/// Bounding rectangle of an object in the image, parts outside the image included; sides as PixelBox has them.
struct ImageExtent {
  Eigen::Vector2d low_px = Eigen::Vector2d::Zero();
  Eigen::Vector2d high_px = Eigen::Vector2d::Zero();
  Eigen::Vector2d low_sigma_px = Eigen::Vector2d::Zero();
  Eigen::Vector2d high_sigma_px = Eigen::Vector2d::Zero();
};

/// The space that an object occupies, as a region of stereo measurements.
struct PredictedVolume {
  /// Homogeneous; from (u_left, v, disparity, 1), px, to the axes of its box with the origin at the centre, m.
  Eigen::Matrix4d T_box_stereo = Eigen::Matrix4d::Identity();
  Eigen::Vector3d half_size_m = Eigen::Vector3d::Zero();
  Eigen::Vector3d sigma_m = Eigen::Vector3d::Zero();  ///< Standard deviation of the faces along each axis.

  /// Density of the object's points at a measured one, relative to that in a volume known exactly: 0 to 1.
  [[nodiscard]] double density_at(const Eigen::Vector2d& left_px, double disparity_px, double disparity_sigma_px) const;
  /// Whether the box lies between the camera and a measured point.
  [[nodiscard]] bool hides(const Eigen::Vector2d& left_px, double disparity_px) const;
};

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
  std::optional<ImageExtent> extent = {};  ///< Of its box.
  std::optional<PredictedVolume> volume = {};
};

}  // namespace kinetrace::tracking
