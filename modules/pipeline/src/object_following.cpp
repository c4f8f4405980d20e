// The part of ObjectState that goes on without a reconstruction: by stereo position, by direction, or as it last went.
#include <algorithm>
#include <cmath>

#include "object_limits.hpp"
#include "object_state.hpp"

namespace kinetrace::pipeline {
namespace {

constexpr double kHiddenFactor = 4.0;    // Surface drift of an object that is partly outside the image.
constexpr double kRestDrift_mps = 0.02;  // How the place of something at rest grows uncertain while it is not seen.
constexpr double kStartSigma_m = 0.5;    // Of the position handed to the stereo-only filter without a reconstruction.
/// Of something that is back, coasting tells the place better than the middle of what is seen of it, up to this many
/// times as uncertain: it errs on no side.
constexpr double kWorthCoasting = 2.0;
/// Found for longer without a break, something shows whether it still rests.
constexpr std::int64_t kSureOfItsMotion_ns = 400'000'000;
constexpr double kObservedSigma_px = 0.3;
/// Matched for longer without a break: where it is may be wrong, what it is is not.
constexpr std::int64_t kSureOfItsMask_ns = 400'000'000;
constexpr double kElsewhereSigmas = 3.0;
constexpr double kLikelySigmas = 2.0;
constexpr double kSlow_mps = 1.0;  // Common errors of what is seen of something amount to that far away.

/// Fast enough that rest is unlikely, if not ruled out.
bool seems_to_move(const trajectory::MotionEstimate& motion) {
  const double speed_mps = motion.velocity_mps.norm();
  return speed_mps > kSlow_mps && speed_mps > kLikelySigmas * std::sqrt(motion.covariance.trace());
}

}  // namespace

void ObjectState::start_filter() {
  // The pose at hand is the last frame's, or this one's at birth.
  const bool known_before = motion_.size() > 0;
  const trajectory::MotionEstimate motion = motion_.at(0);
  // Its last poses may be too uncertain to show a motion that was well known before.
  const bool keeps_motion = known_motion_ && known_motion_->moving;
  // Out of sight, what showed no motion is best looked for where it was, unless it seemed to have one that was not sure
  // yet. What had been resting before it was found again for a few frames has hardly begun to move just then: that is
  // its place being put right.
  const bool stays = !keeps_motion && ((shows_no_motion() && !seems_to_move(motion)) ||
                                       (rested_ && !tracked_run_.exceeds(kSureOfItsMotion_ns)));
  Eigen::Vector3d velocity_mps = Eigen::Vector3d::Zero();
  if (motion.moving && !stays) {
    velocity_mps = motion.velocity_mps;
  } else if (keeps_motion) {
    velocity_mps = T_world_obj_.rotation * known_motion_->velocity.tail<3>();
  }
  const double sigma_m = reconstructed_ ? kReconstructedSigma_m : kStartSigma_m;
  filter_.start(known_before ? previous_timestamp_ns_ : timestamp_ns_, middle_m(), velocity_mps,
                sigma_m * sigma_m * Eigen::Matrix3d::Identity(), stays);
}

void ObjectState::follow_without_body(const StereoObservation& observation, const CameraState& camera) {
  if (!filter_.initialised()) {
    start_filter();
  }
  const bool observed = observation.features >= config_.stereo_only_min_features;
  const double depth_m = observation.features > 0 ? position_in_camera(geometry_, observation).z() : 0.0;
  if (known_motion_ && seen_elsewhere(observation, camera)) {
    known_motion_.reset();
  }
  const bool expected_here = known_motion_ && coasting_sigma_m() < kWorthCoasting * extent_sigma_m(depth_m);
  if (status_ == BodyStatus::kLost && observed && !filter_.at_rest() && !expected_here) {
    reconstructed_ = false;  // It is back: what was reconstructed before has left the map long ago.
  }
  // What neither rests nor surely moves has no way to go on by.
  const bool has_way = known_motion_ && (filter_.at_rest() || known_motion_->moving);
  if (reconstructed_ && has_way && (mostly_occluded() || (cut_off() && well_known())) &&
      (observation.features == 0 || coasting_sigma_m() < extent_sigma_m(depth_m))) {
    coast(observed);
    return;
  }
  filter_.predict(timestamp_ns_);
  if (rigid() && !filter_.at_rest() && camera.valid && camera.T_world_cam_before &&
      observation.motion.features >= config_.stereo_only_min_features) {
    filter_.update_motion(observation.motion, interval_s_, camera.T_world_cam, *camera.T_world_cam_before);
  }
  const double surface_sigma_m =
      std::max(extent_sigma_m(depth_m), half_hidden() ? kHiddenFactor * surface_sigma_m_ : 0.0);
  const trajectory::StereoPositionFilter before = filter_;
  bool seen = observed && camera.valid &&
              filter_.update(part_seen(observation, camera), observation.features, camera.T_world_cam, surface_sigma_m);
  if (!observed && track_.missed_frames == 0 && camera.valid && !filter_.at_rest()) {
    const PixelBox& box = track_.box_px;
    filter_.update_direction({0.5 * (box.x0 + box.x1 - 1), 0.5 * (box.y0 + box.y1 - 1)}, camera.T_world_cam,
                             std::max(surface_sigma_m, width_m_));
  }
  const bool still_there =
      seen && before.at_rest() && reconstructed_ && (!filter_.jumped() || lies_on_it(observation, camera));
  if (still_there) {
    // The middle of what is seen of it says that it is still there, but not better than its reconstruction where.
    filter_ = before;
  }
  if (seen && !still_there && filter_.jumped() && reconstructed_ && !matched_run_.exceeds(kSureOfItsMask_ns)) {
    filter_ = before;
    identity_switched_ = true;
    seen = false;
  } else if (seen && !still_there && filter_.jumped()) {
    // What was followed so far was something else: where that was says nothing about the motion of this.
    motion_.reset();
    reconstructed_ = false;
    frame_change_ = FrameChange::kReplaced;
  }
  T_world_obj_.translation = filter_.position_m() + T_world_obj_.rotation * stereo_offset_m_;
  // A rotation that is not measured: about a radian. Where on the object the seen surface lies errs in common over
  // frames: averaging does not make it surer.
  set_covariance(1.0, filter_.position_covariance() + surface_sigma_m * surface_sigma_m * Eigen::Matrix3d::Identity());
  count_prediction(seen);
}

bool ObjectState::seen_elsewhere(const StereoObservation& observation, const CameraState& camera) const {
  if (observation.features < 2 * min_points_ || !camera.valid) {
    return false;
  }
  const Eigen::Vector3d observed_cam_m = position_in_camera(geometry_, observation);
  const double off_m = off_body(camera.T_world_cam * observed_cam_m, coasted_pose() * -stereo_offset_m_).norm();
  const double depth_m = observed_cam_m.z();
  const double sigma_m = std::hypot(coasting_sigma_m(), extent_sigma_m(depth_m), depth_sigma_m(depth_m));
  return off_m > kElsewhereSigmas * sigma_m;
}

Eigen::Vector3d ObjectState::part_seen(const StereoObservation& observation, const CameraState& camera) const {
  if (!reconstructed_ || !half_hidden()) {
    return observation.uvd_px;
  }
  const Eigen::Vector3d observed_m = camera.T_world_cam * position_in_camera(geometry_, observation);
  const Eigen::Vector3d p_cam =
      camera.T_world_cam.inverse() * (filter_.position_m() + off_body(observed_m, filter_.position_m()));
  if (p_cam.z() <= 0.0) {
    return observation.uvd_px;
  }
  const Eigen::Vector3d uvr_px = geometry_.project(p_cam);
  return {uvr_px.x(), uvr_px.y(), uvr_px.x() - uvr_px.z()};
}

bool ObjectState::lies_on_it(const StereoObservation& observation, const CameraState& camera) const {
  const Eigen::Vector3d observed_m = camera.T_world_cam * position_in_camera(geometry_, observation);
  const Eigen::Vector3d off_m = camera.T_world_cam.rotation.transpose() * off_body(observed_m, middle_m());
  const double depth_m = (camera.T_world_cam.inverse() * observed_m).z();
  return off_m.head<2>().norm() <= kReachAtRest_m &&
         std::abs(off_m.z()) <= kReachAtRest_m + 2.0 * depth_sigma_m(depth_m);
}

double ObjectState::depth_sigma_m(double depth_m) const {
  return kObservedSigma_px * depth_m * depth_m / (geometry_.fx_px * geometry_.baseline_m);
}

double ObjectState::coasting_sigma_m() const {
  const double growth_m =
      filter_.at_rest() ? kRestDrift_mps * unseen_s_ : acceleration_mps2_ * acceleration_gain_s2(unseen_s_);
  return kReconstructedSigma_m + growth_m;
}

bool ObjectState::keeps_motion() const noexcept {
  return !filter_.at_rest() && known_motion_->moving;
}

Se3 ObjectState::coasted_pose() const {
  if (!keeps_motion()) {
    return T_world_obj_;
  }
  const double dt_s = 1e-9 * static_cast<double>(timestamp_ns_ - previous_timestamp_ns_);
  const Vector6d& velocity = known_motion_->velocity;
  // A slower turn is as well the noise of its last poses, and adds up in what is not seen.
  const bool turns = velocity.head<3>().norm() > turn_rate_radps_;
  const Eigen::Vector3d turn_rad = turns ? Eigen::Vector3d(dt_s * velocity.head<3>()) : Eigen::Vector3d::Zero();
  return (known_motion_->T_world_obj * Se3{so3_exp(turn_rad), dt_s * velocity.tail<3>()}).orthonormalised();
}

void ObjectState::coast(bool observed) {
  const double dt_s = 1e-9 * static_cast<double>(timestamp_ns_ - previous_timestamp_ns_);
  const bool at_rest = filter_.at_rest();
  const Vector6d velocity = keeps_motion() ? known_motion_->velocity : Vector6d(Vector6d::Zero());
  T_world_obj_ = coasted_pose();
  known_motion_->T_world_obj = keeps_motion() ? T_world_obj_ : known_motion_->T_world_obj;
  unseen_s_ += dt_s;
  const double turn_rad = kExpectedFloor_rad + turn_radps2_ * acceleration_gain_s2(unseen_s_);
  const double way_m = coasting_sigma_m();
  const Eigen::Matrix3d spread = way_m * way_m * Eigen::Matrix3d::Identity();
  filter_.start(timestamp_ns_, middle_m(), T_world_obj_.rotation * velocity.tail<3>(), spread, at_rest);
  set_covariance(turn_rad * turn_rad, spread);
  // What is detected where it is expected is not lost, however little of it is seen.
  if ((at_rest || observed) && track_.missed_frames == 0) {
    predicted_.reset();
  }
  count_prediction(false);
}

void ObjectState::count_prediction(bool seen) noexcept {
  if (seen) {
    predicted_.reset();
    unseen_s_ = 0.0;
    status_ = BodyStatus::kStereoOnly;
    return;
  }
  predicted_.add_frame(interval_ns_);
  status_ = predicted_.exceeds(lost_after_ns_) ? BodyStatus::kLost : BodyStatus::kPropagated;
}

}  // namespace kinetrace::pipeline
