// Velocity of the camera between published frames.
#pragma once

#include <cstdint>
#include <optional>

#include <Eigen/Core>

#include "kinetrace/core/se3.hpp"
#include "kinetrace/publishing/published_frame.hpp"

namespace kinetrace::publishing {

struct CameraMotion {
  bool is_known = false;                                             ///< False: all members are zero.
  Eigen::Vector3d velocity_mps = Eigen::Vector3d::Zero();            ///< Camera frame.
  Eigen::Vector3d angular_velocity_radps = Eigen::Vector3d::Zero();  ///< Camera frame.
  /// Of (angular velocity, velocity), camera frame. An upper bound: the errors of consecutive poses are taken to be
  /// independent, while in truth they have much in common.
  Matrix6d covariance = Matrix6d::Zero();
};

/// Velocity from consecutive camera poses.
class CameraMotionMeter {
 public:
  /// No velocity after a longer gap, or from poses that are predicted or lost.
  static constexpr std::int64_t kMaxPause_ns = 1'000'000'000;

  CameraMotion update(const PublishedFrame& frame) noexcept;

 private:
  struct Previous {
    std::int64_t timestamp_ns;
    Se3 T_world_cam;
    Matrix6d covariance;
  };
  std::optional<Previous> previous_;
};

}  // namespace kinetrace::publishing
