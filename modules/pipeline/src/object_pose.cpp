// The part of ObjectState that finds the pose of its reconstruction, recognises it and begins it anew.
#include <algorithm>
#include <array>
#include <cmath>

#include <Eigen/Cholesky>

#include "kinetrace/trajectory/composition.hpp"
#include "object_limits.hpp"
#include "object_state.hpp"

namespace kinetrace::pipeline {
namespace {

// Of a guess where it has come back, however long it was away: it goes on as it went, and turns little.
constexpr double kGuessTurn_rad = 0.05;
constexpr double kGuessPlace_m = 0.27;
constexpr double kExpectedFloor_m = 0.02;  // Error of where a smoothed pose puts the object.
constexpr double kReachableGate = 36.0;    // Chi-square of six numbers.
constexpr double kConsensusPart = 0.9;     // So many of its points cannot all have passed to something else.
constexpr double kFarOffIt_m = 2.0;        // An origin farther from the middle of what is seen is on something else.
constexpr std::int64_t kMaxUncertain_ns = 1'500'000'000;
// A reconstruction scatters no more than the background's, up to reflections and what moves on it. More means that it
// holds on to a wrong relief: seen from afar, a thing with a wrong relief and a wrong rotation looks nearly right.
constexpr double kMaxResidualSigma_px = 0.3;
constexpr double kMaxResidualRatio = 2.0;
constexpr int kFailedResidualFrames = 4;
// In frames: each one is another chance to fit.
constexpr double kMaxInconsistencies = 3.0;  // Then what was reconstructed is not what is seen.
constexpr int kMinResidualFrames = 6;        // Samples of the scatter.

}  // namespace

bool ObjectState::locate(const FeatureFrame& frame, const CameraState& camera) {
  if (rigid() && body_.active() && (fails_residual_check(camera) || inconsistency_count_ >= kMaxInconsistencies)) {
    body_.end();
    known_motion_.reset();
    recogniser_.clear();  // What was remembered has the same wrong relief, or is of something else.
    inconsistency_count_ = 0.0;
  }
  if (!rigid() || !body_.active()) {
    return false;
  }
  const bool found = find_pose(frame, camera);
  count_inconsistency(found);
  return found;
}

bool ObjectState::find_pose(const FeatureFrame& frame, const CameraState& camera) {
  const std::optional<sfm::BodyReconstruction::Expectation> expected = expected_pose(camera);
  if (body_.locate(frame, track_.label(), expected ? &*expected : nullptr).status != BodyStatus::kTracked ||
      !camera.valid) {
    return false;
  }
  if (expected && !has_inlier_consensus() && !passes_innovation_gate(*expected)) {
    body_.refuse_pose();
    return false;
  }
  return true;
}

// Its points are seen, and yet it is not where they say or not where it can have gone to.
void ObjectState::count_inconsistency(bool found) noexcept {
  const bool is_inconsistent = !found && body_.estimate().observations >= 2 * min_points_;
  inconsistency_count_ =
      is_inconsistent ? inconsistency_count_ + 1.0 : std::max(0.0, inconsistency_count_ - (found ? 0.5 : 0.0));
}

bool ObjectState::fails_residual_check(const CameraState& camera) {
  const bool now =
      status_ == BodyStatus::kTracked && body_.residual_frames() >= kMinResidualFrames &&
      body_.residual_sigma_px() > std::max(kMaxResidualSigma_px, kMaxResidualRatio * camera.residual_sigma_px);
  failed_residual_frames_ = now ? failed_residual_frames_ + 1 : 0;
  if (failed_residual_frames_ < kFailedResidualFrames) {
    return false;
  }
  failed_residual_frames_ = 0;
  return true;
}

std::optional<sfm::BodyReconstruction::Expectation> ObjectState::expected_pose(const CameraState& camera) const {
  if (!known_motion_ || status_ != BodyStatus::kTracked || !camera.valid) {
    return std::nullopt;
  }
  const double dt_s = 1e-9 * static_cast<double>(timestamp_ns_ - previous_timestamp_ns_);
  const Vector6d step = dt_s * known_motion_->velocity;
  const Se3 T_world_obj = known_motion_->T_world_obj * Se3{so3_exp(step.head<3>()), step.tail<3>()};
  const double unseen_s2 = acceleration_gain_s2(dt_s);
  Vector6d sigma;
  sigma.head<3>().setConstant(turn_radps2_ * unseen_s2 + kExpectedFloor_rad);
  sigma.tail<3>().setConstant(acceleration_mps2_ * unseen_s2 + kExpectedFloor_m);
  // In the object's own axes, where T_obj_cam is perturbed too.
  Matrix6d to_object = Matrix6d::Zero();
  to_object.topLeftCorner<3, 3>() = T_world_obj.rotation.transpose();
  to_object.bottomRightCorner<3, 3>() = T_world_obj.rotation.transpose();
  Matrix6d covariance = to_object * covariance_ * to_object.transpose();
  covariance.diagonal() += sigma.cwiseAbs2();
  return sfm::BodyReconstruction::Expectation{T_world_obj.inverse() * camera.T_world_cam, covariance};
}

bool ObjectState::has_inlier_consensus() const {
  const BodyEstimate& found = body_.estimate();
  return found.inliers >= 2 * min_points_ && found.inliers >= kConsensusPart * found.observations;
}

bool ObjectState::passes_innovation_gate(const sfm::BodyReconstruction::Expectation& expected) const {
  const BodyEstimate& found = body_.estimate();
  const Vector6d off = left_difference(expected.T_body_cam, found.T_body_cam);
  const Matrix6d spread = expected.covariance + found.covariance;
  return off.dot(spread.ldlt().solve(off)) <= kReachableGate;
}

bool ObjectState::recognise(const CameraState& camera, const features::FeatureFrontEnd& front_end) {
  const double unknown_s = 1e-9 * static_cast<double>(timestamp_ns_ - known_timestamp_ns_);
  const double unknown_s2 = acceleration_gain_s2(unknown_s);
  const PoseGuess guess{
      .T_obj_cam = T_world_obj_.inverse() * camera.T_world_cam,
      .turn_sigma_rad = std::min(kExpectedFloor_rad + turn_radps2_ * unknown_s2, kGuessTurn_rad),
      .place_sigma_m = std::min(kReconstructedSigma_m + acceleration_mps2_ * unknown_s2, kGuessPlace_m)};
  const std::optional<Se3> found = recogniser_.recognise(guess, body_, track_.label(), front_end);
  if (!found) {
    return false;
  }
  T_world_obj_ = (camera.T_world_cam * found->inverse()).orthonormalised();
  if (known_motion_) {
    known_motion_->T_world_obj = T_world_obj_;
  }
  return true;
}

void ObjectState::begin_body(const StereoObservation& observation, const CameraState& camera,
                             const features::FeatureFrontEnd& front_end) {
  if (!frame_fixed_ || stereo_offset_m_.norm() > width_m_ + kFarOffIt_m) {
    // What stereo has followed so far may have been something next to the object; its frame belongs on its points.
    const Eigen::Vector3d observed_m = camera.T_world_cam * position_in_camera(geometry_, observation);
    frame_change_ = frame_fixed_ ? FrameChange::kReplaced : FrameChange::kRefined;
    T_world_obj_.translation = observed_m;
    stereo_offset_m_.setZero();
    recogniser_.clear();
  } else if (recogniser_.knows_it() && !filter_.at_rest()) {
    pose_ambiguous_ = !recognise(camera, front_end);
    frame_change_ = pose_ambiguous_ ? FrameChange::kNone : FrameChange::kRefined;
    ambiguous_frames_ = 0;
    uncertain_time_.reset();
  }
  body_.begin(T_world_obj_.inverse() * camera.T_world_cam, status_);
}

void ObjectState::resolve_pose(const CameraState& camera, const features::FeatureFrontEnd& front_end) {
  T_world_obj_ = camera.T_world_cam * body_.estimate().T_body_cam.inverse();
  const Se3 T_obj_provisional_world = T_world_obj_.inverse();
  if (recognise(camera, front_end)) {
    pose_ambiguous_ = false;
    correction_ =
        FrameCorrection{T_obj_provisional_world * T_world_obj_, static_cast<std::size_t>(ambiguous_frames_) + 1};
    body_.begin(T_world_obj_.inverse() * camera.T_world_cam, status_);
    return;
  }
  ++ambiguous_frames_;
  uncertain_time_.add_frame(interval_ns_);
  pose_ambiguous_ = !uncertain_time_.exceeds(kMaxUncertain_ns);  // Later it looks too different: the guess stands.
}

}  // namespace kinetrace::pipeline
