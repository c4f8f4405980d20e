// What a stereo rig's calibration does not know: a right camera that is turned, set off or drifting, a wrong focal
// length.
#pragma once

#include <cstdint>

#include <Eigen/Core>

#include "camera/camera_rig.hpp"
#include "kinetrace/core/result.hpp"

namespace kinetrace::simulator {

struct RigErrors {
  /// The right camera is turned by exp([turn]x) from where its calibration has it, seen from that camera.
  Eigen::Vector3d turn_rad = Eigen::Vector3d::Zero();
  /// How far the baseline points down (y) and forward (z) from the left camera's x axis. Its length stays.
  Eigen::Vector2d baseline_rad = Eigen::Vector2d::Zero();
  /// From here on; before, the right camera stands as calibrated.
  double knock_s = 0.0;
  /// True focal length of both cameras over the calibrated one, less one.
  double focal = 0.0;
  /// Amplitude of a slow drifting of the right camera's direction, and half as much of its principal point.
  double drift_mrad = 0.0;

  /// Where the right camera stands at this moment against its calibration.
  struct RightCamera {
    Eigen::Vector3d turn_rad = Eigen::Vector3d::Zero();
    Eigen::Vector2d baseline_rad = Eigen::Vector2d::Zero();
    Eigen::Vector2d principal_shift = Eigen::Vector2d::Zero();  ///< In normalised image coordinates.
  };
  /// `seed` draws phases and periods of the drift.
  [[nodiscard]] RightCamera right_camera(double time_s, std::uint32_t seed) const;
  /// The pictures are not those of the calibrated right camera.
  [[nodiscard]] bool move_right_camera() const;
  [[nodiscard]] Status validate() const;
};

/// The rig as a calibration that has its focal length wrong describes it.
[[nodiscard]] CameraRig miscalibrated(const CameraRig& rig, double focal);

}  // namespace kinetrace::simulator
