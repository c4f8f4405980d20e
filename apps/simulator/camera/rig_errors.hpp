// Errors of a stereo rig's calibration: a right camera that is rotated, displaced or drifting, a wrong focal length.
#pragma once

#include <cstdint>

#include <Eigen/Core>

#include "camera/camera_rig.hpp"
#include "kinetrace/core/result.hpp"

namespace kinetrace::simulator {

struct RigErrors {
  /// Rotation exp([turn]x) of the right camera from its calibrated orientation, in that camera's frame.
  Eigen::Vector3d turn_rad = Eigen::Vector3d::Zero();
  /// How far the baseline points down (y) and forward (z) from the left camera's x axis. Its length stays.
  Eigen::Vector2d baseline_rad = Eigen::Vector2d::Zero();
  /// Start time of turn and baseline errors; before, the right camera has its calibrated pose.
  double knock_s = 0.0;
  /// Relative error of both focal lengths: true over calibrated, minus one.
  double focal = 0.0;
  /// Amplitude of a slow drift of the right camera's direction; half as much for its principal point.
  double drift_mrad = 0.0;

  /// Error of the right camera's pose and principal point against the calibration.
  struct RightCamera {
    Eigen::Vector3d turn_rad = Eigen::Vector3d::Zero();
    Eigen::Vector2d baseline_rad = Eigen::Vector2d::Zero();
    Eigen::Vector2d principal_shift = Eigen::Vector2d::Zero();  ///< In normalised image coordinates.
  };
  /// `seed` determines phases and periods of the drift.
  [[nodiscard]] RightCamera right_camera(double time_s, std::uint32_t seed) const;
  /// Whether the right pictures differ from those of the calibrated right camera.
  [[nodiscard]] bool move_right_camera() const;
  [[nodiscard]] Status validate() const;
};

/// The rig as described by a calibration with a wrong focal length.
[[nodiscard]] CameraRig miscalibrated(const CameraRig& rig, double focal);

}  // namespace kinetrace::simulator
