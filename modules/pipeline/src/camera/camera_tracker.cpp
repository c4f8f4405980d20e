#include "camera/camera_tracker.hpp"

#include <optional>

namespace kinetrace::pipeline {
namespace {

constexpr std::int64_t kLostAfter_ns = 200'000'000;

}  // namespace

Se3 CameraTracker::locate(const FeatureFrame& frame, std::int64_t interval_ns, bool is_cut) {
  if (!background_.active()) {
    background_.begin(Se3{});
    return {};
  }
  const Se3 T_world_prev = background_.history(0).T_body_cam;
  const bool found = background_.locate(frame, kBackgroundLabel).status == BodyStatus::kTracked;
  if (found && !is_cut) {
    predicted_.reset();
  } else {
    if (found) {
      // The apparent matches are false: similar points of another scene.
      background_.refuse_pose();
    }
    predicted_.add_frame(interval_ns);
    ++camera_lost_frames_;
    // Known points no longer fit: a new map starts at the predicted pose with this frame's stereo; after a cut where
    // the camera was.
    background_.begin(is_cut ? T_world_prev : background_.estimate().T_body_cam,
                      predicted_.exceeds(kLostAfter_ns) ? BodyStatus::kLost : BodyStatus::kPropagated);
    if (is_cut) {
      background_.forget_motion();
    }
  }
  return T_world_prev.inverse() * background_.estimate().T_body_cam;
}

CameraState CameraTracker::state(std::size_t age) const {
  const FinalisedPose pose = background_.history(age);
  CameraState camera{.T_world_cam = pose.T_body_cam,
                     .T_world_cam_before = std::nullopt,
                     .covariance = pose.covariance,
                     .valid = pose.status == BodyStatus::kTracked};
  if (age + 1 < background_.history_size()) {
    const FinalisedPose before = background_.history(age + 1);
    camera.T_world_cam_before = before.status == BodyStatus::kTracked ? std::optional(before.T_body_cam) : std::nullopt;
  }
  return camera;
}

CameraResult CameraTracker::result(std::size_t age) const {
  const FinalisedPose pose = background_.history(age);
  return {pose.status, pose.T_body_cam, rotation_position_covariance(pose.T_body_cam, pose.covariance), pose.inliers};
}

}  // namespace kinetrace::pipeline
