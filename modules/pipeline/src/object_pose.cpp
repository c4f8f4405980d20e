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
constexpr double kUnanimousPart = 0.9;     // So many of its points cannot all have passed to something else.
constexpr double kFarOffIt_m = 2.0;        // An origin farther from the middle of what is seen is on something else.
constexpr std::int64_t kMaxUnsure_ns = 1'500'000'000;
// A reconstruction scatters no more than the background's, up to reflections and what moves on it. More means that it
// holds on to a wrong relief: seen from afar, a thing with a wrong relief and a wrong rotation looks nearly right.
constexpr double kIllScatter_px = 0.3;
constexpr double kIllScatterRatio = 2.0;
constexpr int kIllFrames = 4;
// In frames: each one is another chance to fit.
constexpr double kMostContradictions = 3.0;  // Then what was reconstructed is not what is seen.
constexpr int kSettledScatterFrames = 6;     // Samples of the scatter.

}  // namespace

bool ObjectState::locate(const FeatureFrame& frame, const CameraState& camera) {
  if (rigid() && body_.active() && (ill_fitting(camera) || contradictions_ >= kMostContradictions)) {
    body_.end();
    known_motion_.reset();
    recogniser_.clear();  // What was remembered has the same wrong relief, or is of something else.
    contradictions_ = 0.0;
  }
  if (!rigid() || !body_.active()) {
    return false;
  }
  const bool found = find_pose(frame, camera);
  count_contradiction(found);
  return found;
}

bool ObjectState::find_pose(const FeatureFrame& frame, const CameraState& camera) {
  const std::optional<sfm::BodyReconstruction::Expectation> expected = expected_pose(camera);
  if (body_.locate(frame, track_.label(), expected ? &*expected : nullptr).status != BodyStatus::kTracked ||
      !camera.valid) {
    return false;
  }
  if (expected && !unanimous() && !reachable(*expected)) {
    body_.refuse_pose();
    return false;
  }
  return true;
}

// Its points are seen, and yet it is not where they say or not where it can have gone to.
void ObjectState::count_contradiction(bool found) noexcept {
  const bool contradicts = !found && body_.estimate().observations >= 2 * min_points_;
  contradictions_ = contradicts ? contradictions_ + 1.0 : std::max(0.0, contradictions_ - (found ? 0.5 : 0.0));
}

bool ObjectState::ill_fitting(const CameraState& camera) {
  const bool now = status_ == BodyStatus::kTracked && body_.scatter_frames() >= kSettledScatterFrames &&
                   body_.scatter_px() > std::max(kIllScatter_px, kIllScatterRatio * camera.scatter_px);
  ill_fitting_frames_ = now ? ill_fitting_frames_ + 1 : 0;
  if (ill_fitting_frames_ < kIllFrames) {
    return false;
  }
  ill_fitting_frames_ = 0;
  return true;
}

std::optional<sfm::BodyReconstruction::Expectation> ObjectState::expected_pose(const CameraState& camera) const {
  if (!known_motion_ || status_ != BodyStatus::kTracked || !camera.valid) {
    return std::nullopt;
  }
  const double dt_s = 1e-9 * static_cast<double>(timestamp_ns_ - previous_timestamp_ns_);
  const Vector6d step = dt_s * known_motion_->velocity;
  const Se3 T_world_obj = known_motion_->T_world_obj * Se3{so3_exp(step.head<3>()), step.tail<3>()};
  const double unseen_s2 = square_of_time(dt_s);
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

bool ObjectState::unanimous() const {
  const BodyEstimate& found = body_.estimate();
  return found.inliers >= 2 * min_points_ && found.inliers >= kUnanimousPart * found.observations;
}

bool ObjectState::reachable(const sfm::BodyReconstruction::Expectation& expected) const {
  const BodyEstimate& found = body_.estimate();
  const Vector6d off = left_difference(expected.T_body_cam, found.T_body_cam);
  const Matrix6d spread = expected.covariance + found.covariance;
  return off.dot(spread.ldlt().solve(off)) <= kReachableGate;
}

bool ObjectState::recognise(const CameraState& camera, const features::FeatureFrontEnd& front_end) {
  const double unknown_s = 1e-9 * static_cast<double>(timestamp_ns_ - known_timestamp_ns_);
  const double unknown_s2 = square_of_time(unknown_s);
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

void ObjectState::begin_body(const StereoSighting& sighting, const CameraState& camera,
                             const features::FeatureFrontEnd& front_end) {
  if (!frame_fixed_ || stereo_offset_m_.norm() > width_m_ + kFarOffIt_m) {
    // What stereo has followed so far may have been something next to the object; its frame belongs on its points.
    const Eigen::Vector3d sighted_m = camera.T_world_cam * position_in_camera(geometry_, sighting);
    frame_change_ = frame_fixed_ ? FrameChange::kReplaced : FrameChange::kRefined;
    T_world_obj_.translation = sighted_m;
    stereo_offset_m_.setZero();
    recogniser_.clear();
  } else if (recogniser_.knows_it() && !filter_.at_rest()) {
    unsure_ = !recognise(camera, front_end);
    frame_change_ = unsure_ ? FrameChange::kNone : FrameChange::kRefined;
    unsure_frames_ = 0;
    unsure_time_.reset();
  }
  body_.begin(T_world_obj_.inverse() * camera.T_world_cam, status_);
}

void ObjectState::make_sure(const CameraState& camera, const features::FeatureFrontEnd& front_end) {
  T_world_obj_ = camera.T_world_cam * body_.estimate().T_body_cam.inverse();
  const Se3 T_obj_guessed_world = T_world_obj_.inverse();
  if (recognise(camera, front_end)) {
    unsure_ = false;
    correction_ = FrameCorrection{T_obj_guessed_world * T_world_obj_, static_cast<std::size_t>(unsure_frames_) + 1};
    body_.begin(T_world_obj_.inverse() * camera.T_world_cam, status_);
    return;
  }
  ++unsure_frames_;
  unsure_time_.add_frame(interval_ns_);
  unsure_ = !unsure_time_.exceeds(kMaxUnsure_ns);  // Later it looks too different: the guess stands.
}

}  // namespace kinetrace::pipeline
