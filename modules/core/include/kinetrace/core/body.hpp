// A body is a rigid thing with its own reconstruction: body 0 is the background, bodies 1..n are the objects. All go
// through the same code.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <string_view>

#include <Eigen/Core>

#include "kinetrace/core/se3.hpp"
#include "kinetrace/core/stereo_geometry.hpp"

namespace kinetrace {

enum class BodyStatus : std::uint8_t {
  kInitializing,  ///< No pose yet: too few points so far.
  kTracked,       ///< Pose from the body's own reconstruction.
  kStereoOnly,  ///< Too few points for a reconstruction (far, small, non-rigid): position from this frame's stereo, no
                ///< rotation.
  kPropagated,  ///< No support in this frame: pose predicted by the last motion.
  kLost,        ///< No support for longer than a prediction is valid.
};

[[nodiscard]] constexpr std::string_view to_string(BodyStatus status) noexcept {
  switch (status) {
    case BodyStatus::kInitializing: return "initializing";
    case BodyStatus::kTracked: return "tracked";
    case BodyStatus::kStereoOnly: return "stereo_only";
    case BodyStatus::kPropagated: return "propagated";
    case BodyStatus::kLost: return "lost";
  }
  return "lost";
}

/// A reconstructed point in its body's frame.
struct BodyPoint {
  std::uint32_t id = 0;  ///< Unique within the run; the id of the feature it was made from.
  Eigen::Vector3f position_m{0.F, 0.F, 0.F};
  float reprojection_error_px = 0.F;  ///< RMS over its observations in the window.
  std::uint16_t observations = 0;     ///< Frames it was seen in, over its life.
  std::uint8_t intensity = 0;
};

/// One observation of a point in the current frame.
struct PointObservation {
  std::uint32_t point_id = 0;
  float u_left_px = 0.F;
  float v_px = 0.F;
  float u_right_px = kNoRight;
};

/// Final pose of the camera relative to a body at one frame, after the frame has left the window.
struct FinalisedPose {
  std::int64_t frame_index = 0;
  std::int64_t timestamp_ns = 0;
  BodyStatus status = BodyStatus::kLost;
  Se3 T_body_cam;
  Matrix6d covariance = Matrix6d::Zero();  ///< Of T_body_cam, left perturbation (rad, m).
  int inliers = 0;
};

/// Estimate of one body in the current frame. Spans live in the body until its next call.
struct BodyEstimate {
  BodyStatus status = BodyStatus::kInitializing;
  Se3 T_body_cam;                          ///< Newest estimate.
  Matrix6d covariance = Matrix6d::Zero();  ///< Of T_body_cam relative to the fixed poses, left perturbation (rad, m).
  /// Covariance of the drift of the fixed poses since the body began, same convention; to be added.
  Matrix6d drift_covariance = Matrix6d::Zero();
  int observations = 0;  ///< Features of the body in this frame.
  int inliers = 0;       ///< Those that agree with the pose.
  bool is_keyframe = false;
  std::span<const BodyPoint> points;                     ///< Live points.
  std::span<const PointObservation> frame_observations;  ///< Inlier observations of live points in this frame.
  std::span<const BodyPoint> retired;  ///< Points that left the map with this frame, in their final position.
};

}  // namespace kinetrace
