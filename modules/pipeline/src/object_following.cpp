// The part of ObjectState without a reconstruction: prediction, and updates by the other measurements of a frame.
#include <algorithm>
#include <cmath>

#include "kinetrace/objects/rest_evidence.hpp"
#include "object_state.hpp"

namespace kinetrace::pipeline {
namespace {

/// The error of the visible part's centre of a half occluded object is correlated for the whole occlusion: its standard
/// deviation is this many times that of a surface.
constexpr double kOccludedExtentFactor = 4.0;
/// Of a position by one stereo observation.
constexpr double kInitialPositionSigma_m = 0.5;
constexpr double kUnknownRotationSigma_rad = 1.0;
// Standard deviations of a smoothed pose.
constexpr double kPathSigma_rad = 0.002;
constexpr double kPathSigma_m = 0.02;
/// Velocities of overlapping windows are correlated: one piece of evidence in this time.
constexpr double kEvidenceCorrelation_s = 0.4;
/// Moving or rest is decided once the probability of the other is below this.
constexpr double kMaxOtherModelProbability = 0.05;
constexpr double kMaxEvidence = 7.0;   // Upper bound of the evidence, log odds: one to a thousand.
constexpr int kMinSwitchFeatures = 3;  // Fewer features may belong to another object.
constexpr int kMaxRejections = 3;      // Measurements in a row: then the object is elsewhere.
constexpr double kOutlineSigma_m = 0.03;

double log_odds(double probability) {
  return std::log(probability / (1.0 - probability));
}

}  // namespace

void ObjectState::start_filter(const Se3& T_world_obj, const Vector6d& velocity) noexcept {
  const bool has_velocity = motion_.size() >= trajectory::ObjectMotion::kMinSamples;
  objects::MotionStart start{.timestamp_ns = life_.timestamp_ns,
                             .pose = {T_world_obj, life_.covariance},
                             .velocity = velocity,
                             .moving_probability = identity_.moving_probability};
  start.pose.covariance.diagonal().head<3>().array() += kPathSigma_rad * kPathSigma_rad;
  start.pose.covariance.diagonal().tail<3>().array() += kPathSigma_m * kPathSigma_m;
  // A slower turn may be noise of the last poses, and would accumulate while coasting.
  if (velocity.head<3>().norm() <= turn_rate_radps_) {
    start.velocity.head<3>().setZero();
  }
  start.velocity_covariance = has_velocity
                                  ? motion_.at(0).apparent_covariance
                                  : Eigen::Matrix3d(objects::kUnknownVelocitySigma_mps *
                                                    objects::kUnknownVelocitySigma_mps * Eigen::Matrix3d::Identity());
  identity_.filter.start(start);
}

void ObjectState::update_moving_probability() noexcept {
  if (motion_.size() < trajectory::ObjectMotion::kMinSamples) {
    return;
  }
  const trajectory::MotionEstimate current = motion_.at(0);
  const trajectory::MotionEstimate recent = motion_.at(velocity_window_frames_);
  // The velocity a few frames ago has samples on both sides and is mostly more certain.
  const bool is_recent_more_certain =
      motion_.size() >= velocity_window_frames_ + trajectory::ObjectMotion::kMinSamples &&
      recent.apparent_covariance.trace() < current.apparent_covariance.trace();
  const trajectory::MotionEstimate& motion = is_recent_more_certain ? recent : current;
  const double evidence = std::clamp(objects::moving_evidence(motion.velocity_mps, motion.apparent_covariance),
                                     -kMaxEvidence, kMaxEvidence);
  const double before =
      log_odds(identity_.filter.initialised() ? identity_.filter.moving_probability() : identity_.moving_probability);
  const double now = before + std::min(frame_.interval_s / kEvidenceCorrelation_s, 1.0) * (evidence - before);
  identity_.moving_probability = 1.0 / (1.0 + std::exp(-now));
}

void ObjectState::follow(const StereoObservation& observation, const CameraState& camera) {
  objects::MotionFilter& filter = identity_.filter;
  if (!filter.initialised()) {
    life_.covariance.setZero();
    life_.covariance.diagonal() << Eigen::Vector3d::Constant(kUnknownRotationSigma_rad * kUnknownRotationSigma_rad),
        Eigen::Vector3d::Constant(kInitialPositionSigma_m * kInitialPositionSigma_m);
    start_filter(identity_.T_world_obj, Vector6d::Zero());
  }
  filter.predict(life_.timestamp_ns);
  identity_.T_world_obj = filter.pose();
  const Fix fix = camera.valid ? update_filter(observation, camera) : Fix::kNone;
  identity_.T_world_obj = filter.pose();
  life_.covariance = filter.pose_covariance();
  if (!identity_.reconstructed) {
    life_.covariance.topLeftCorner<3, 3>() =
        kUnknownRotationSigma_rad * kUnknownRotationSigma_rad * Eigen::Matrix3d::Identity();
  }
  if (fix == Fix::kStereo) {
    // The position of the visible surface on the object is a correlated error, which averaging does not reduce.
    const double extent_m = extent_sigma_m(visible_center_in_camera_m(camera).z());
    life_.covariance.diagonal().tail<3>().array() += extent_m * extent_m;
  }
  update_status(fix);
}

ObjectState::Fix ObjectState::update_filter(const StereoObservation& observation, const CameraState& camera) {
  update_filter_by_motion(observation, camera);
  return update_filter_by_position(observation, camera);
}

ObjectState::Fix ObjectState::update_filter_by_position(const StereoObservation& observation,
                                                        const CameraState& camera) {
  objects::MotionFilter& filter = identity_.filter;
  if (observation.features < config_.stereo_only_min_features) {
    // The centre of a partly visible mask does not locate the whole.
    if (life_.track.missed_frames == 0 && !(identity_.reconstructed && is_truncated_or_occluded())) {
      filter.update(mask_bearing(), camera.T_world_cam);
    }
    return Fix::kNone;
  }
  if (is_on_predicted_box(observation, camera)) {
    life_.rejections = 0;
    life_.provisional = false;
    return Fix::kConsistentWithPrediction;
  }
  const objects::StereoPosition measured = stereo_position(observation, camera);
  const double expected_sigma_m = std::sqrt(filter.pose_covariance().bottomRightCorner<3, 3>().trace() / 3.0);
  if (filter.update(measured, camera.T_world_cam)) {
    life_.rejections = 0;
    life_.provisional = false;
    const bool is_consistent =
        identity_.reconstructed && is_truncated_or_occluded() && measured.extent_sigma_m > expected_sigma_m;
    return is_consistent ? Fix::kConsistentWithPrediction : Fix::kStereo;
  }
  life_.identity_switched = life_.provisional && observation.agreeing >= kMinSwitchFeatures;
  if (life_.identity_switched || ++life_.rejections < kMaxRejections) {
    return Fix::kNone;
  }
  life_.rejections = 0;
  restart_at_observation(observation, camera);
  return life_.identity_switched ? Fix::kNone : Fix::kStereo;
}

void ObjectState::update_filter_by_motion(const StereoObservation& observation, const CameraState& camera) {
  // Features on a mostly occluded object may lie on the occluder: they count only while moving or rest is undecided.
  const bool is_motion_decided =
      std::abs(identity_.filter.moving_probability() - 0.5) > 0.5 - kMaxOtherModelProbability;
  if (!is_rigid() || (is_mostly_occluded() && is_motion_decided) || !camera.T_world_cam_before ||
      observation.motion.features < config_.stereo_only_min_features) {
    return;
  }
  objects::ImageMotion motion = observation.motion;
  motion.to_origin_m = identity_.T_world_obj.rotation * identity_.to_origin_m;
  motion.interval_s = frame_.interval_s;
  motion.T_world_cam_before = *camera.T_world_cam_before;
  identity_.filter.update(motion, camera.T_world_cam);
}

void ObjectState::restart_at_observation(const StereoObservation& observation, const CameraState& camera) {
  if (identity_.reconstructed && is_newly_matched()) {
    life_.identity_switched = true;
    return;
  }
  // The path so far was that of another object: nothing known in its frame holds for this one.
  if (is_rigid()) {  // an outline's origin is its centre
    identity_.to_origin_m.setZero();
  }
  identity_.filter.restart_at({.uvd_px = observation.uvd_px,
                               .features = observation.features,
                               .to_origin_m = identity_.to_origin_m,
                               .extent_sigma_m = extent_sigma_m(position_in_camera(geometry_, observation).z())},
                              camera.T_world_cam);
  identity_.frame_fixed = identity_.reconstructed = false;
  identity_.area_m2 = identity_.width_m = 0.0;
  life_.pose_ambiguous = false;
  recogniser_.clear();
  motion_.reset();
  box_.reset();
  frame_.change = FrameChange::kReplaced;
}

objects::Bearing ObjectState::mask_bearing() const {
  const PixelBox& box = life_.track.box_px;
  const double depth_m = life_.T_obj_cam.inverse().translation.z();
  return {.uv_px = {box.center_x(), box.center_y()},
          .to_origin_m = is_rigid() ? Eigen::Vector3d(identity_.T_world_obj.rotation * identity_.to_origin_m)
                                    : Eigen::Vector3d::Zero(),  // an outline's origin is its centre
          .extent_sigma_m = std::max(extent_sigma_m(depth_m), identity_.width_m)};
}

bool ObjectState::is_on_predicted_box(const StereoObservation& observation, const CameraState& camera) const {
  const Eigen::Vector3d observed_m = camera.T_world_cam * position_in_camera(geometry_, observation);
  return identity_.reconstructed && is_truncated_or_occluded() && box_.known() && offset_from_box(observed_m).isZero();
}

objects::StereoPosition ObjectState::stereo_position(const StereoObservation& observation,
                                                     const CameraState& camera) const {
  const Eigen::Vector3d p_cam = position_in_camera(geometry_, observation);
  objects::StereoPosition measured{.uvd_px = observation.uvd_px,
                                   .features = observation.features,
                                   .to_origin_m = identity_.T_world_obj.rotation * identity_.to_origin_m,
                                   .extent_sigma_m = extent_sigma_m(visible_center_in_camera_m(camera).z())};
  if (is_truncated_or_occluded()) {
    measured.extent_sigma_m = std::max(measured.extent_sigma_m, kOccludedExtentFactor * surface_sigma_m_);
  } else if (!identity_.reconstructed || identity_.filter.accepts(measured, camera.T_world_cam)) {
    return measured;
  }
  const Eigen::Vector3d on_box_cam_m =
      camera.T_world_cam.inverse() * (visible_center_m() + offset_from_box(camera.T_world_cam * p_cam));
  if (identity_.reconstructed && on_box_cam_m.z() > 0.0) {
    const Eigen::Vector3d uvr_px = geometry_.project(on_box_cam_m);
    measured.uvd_px = {uvr_px.x(), uvr_px.y(), uvr_px.x() - uvr_px.z()};
  }
  return measured;
}

double ObjectState::extent_sigma_m(double depth_m) const {
  const double visible_width_m = life_.track.box_px.width() * std::max(depth_m, 0.0) / geometry_.fx_px;
  // The occluded width follows from masks or, where it has just returned, from the width when last seen whole.
  const double hidden_width_m =
      std::max(visible_width_m * (1.0 / visible_part() - 1.0), identity_.width_m - visible_width_m);
  return (is_rigid() ? surface_sigma_m_ : kOutlineSigma_m) + 0.5 * std::max(hidden_width_m, 0.0);
}

void ObjectState::update_status(Fix fix) noexcept {
  const bool is_detected_at_rest = life_.track.missed_frames == 0 && identity_.filter.at_rest();
  if (fix != Fix::kNone || is_detected_at_rest) {
    life_.predicted.reset();  // An object detected where it is expected is not lost, however little of it is visible.
  }
  if (fix == Fix::kStereo) {
    life_.status = BodyStatus::kStereoOnly;
    return;
  }
  life_.predicted.add_frame(frame_.interval_ns);
  life_.status = life_.predicted.exceeds(lost_after_ns_) ? BodyStatus::kLost : BodyStatus::kPropagated;
}

}  // namespace kinetrace::pipeline
