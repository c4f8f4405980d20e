// The part of ObjectState without a reconstruction: prediction, and updates by the other measurements of a frame.
#include <algorithm>
#include <cmath>

#include "kinetrace/objects/rest_evidence.hpp"
#include "object_state.hpp"

namespace kinetrace::pipeline {
namespace {

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
constexpr double kMaxEvidence = 7.0;  // Upper bound of the evidence, log odds: one to a thousand.
constexpr int kMaxRejections = 3;     // Measurements in a row: then the object is elsewhere.
constexpr double kOutlineSigma_m = 0.03;
/// Of the upper end of a person's outline: of a tenth of a network's masks of rendered people it is off by more.
constexpr double kOutlineTopSigma_m = 0.2;
constexpr double kOutlineDisparitySigma_px = 0.1;  // Median error of rendered people, in three scenes.
constexpr double kUniformVariance = 1.0 / 12.0;    // Of a uniform distribution, by its width squared.
/// More features do not improve their median: their errors are correlated.
constexpr int kMaxSpreadFeatures = 8;

/// Covariance of (rotation, position) of the origin, given that of the rotation and, independent of it, of the visible
/// part: an error of the rotation moves the origin around that part, on an arm of `to_origin_m` (world axes).
Matrix6d about_visible_part(const Matrix6d& covariance, const Eigen::Vector3d& to_origin_m) {
  Matrix6d by_errors = Matrix6d::Identity();
  by_errors.bottomLeftCorner<3, 3>() = -skew(to_origin_m);
  return by_errors * covariance * by_errors.transpose();
}

double log_odds(double probability) {
  return std::log(probability / (1.0 - probability));
}

}  // namespace

void ObjectState::start_filter(const Se3& T_world_obj, const Vector6d& velocity, const Se3& T_world_cam) noexcept {
  const bool has_velocity = motion_.size() >= trajectory::ObjectMotion::kMinSamples;
  objects::MotionStart start{.timestamp_ns = life_.timestamp_ns,
                             .pose = {T_world_obj, life_.covariance},
                             .velocity = velocity,
                             .moving_probability = identity_.moving_probability,
                             .part_covariance_m2 = visible_part_of(T_world_cam).covariance_m2};
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
  const trajectory::MotionEstimate motion = motion_.at(0);
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
    start_filter(identity_.T_world_obj, Vector6d::Zero(), camera.T_world_cam);
  }
  filter.predict(life_.timestamp_ns);
  identity_.T_world_obj = filter.pose();
  if (camera.valid) {
    update_filter_by_motion(observation, camera);
  }
  const bool is_located = camera.valid && update_filter_by_position(observation, camera);
  identity_.T_world_obj = filter.pose();
  life_.covariance = filter.pose_covariance();
  if (identity_.reconstructed) {
    life_.covariance = about_visible_part(life_.covariance, identity_.T_world_obj.rotation * identity_.to_origin_m);
  } else {
    life_.covariance.topLeftCorner<3, 3>() =
        kUnknownRotationSigma_rad * kUnknownRotationSigma_rad * Eigen::Matrix3d::Identity();
    // Its origin will be at the centre of its points, anywhere on it.
    life_.covariance.bottomRightCorner<3, 3>() +=
        part_covariance(visible_center_in_camera_m(camera), camera.T_world_cam.rotation);
  }
  update_status(is_located);
}

bool ObjectState::update_filter_by_position(const StereoObservation& observation, const CameraState& camera) {
  objects::MotionFilter& filter = identity_.filter;
  // Of a person the outline is measured, not where the features lie.
  const int features = is_rigid() ? observation.agreeing : observation.features;
  if (features < config_.stereo_only_min_features) {
    // The centre of a partly visible mask does not locate the whole.
    if (life_.track.missed_frames == 0 && !(identity_.reconstructed && is_truncated_or_occluded())) {
      filter.update(mask_bearing(camera), camera.T_world_cam);
    }
    return false;
  }
  const objects::StereoPosition measured{observation.uvd_px, observation.features, visible_part_of(camera.T_world_cam)};
  if (filter.update(measured, camera.T_world_cam)) {
    life_.rejections = 0;
    life_.provisional = false;
    return true;
  }
  // A mask that is only predicted may lie on another surface, one of an occluded object has features of what is in
  // front of it: they do not show that the object is elsewhere.
  const bool is_seen = life_.track.missed_frames == 0 && !is_mostly_occluded();
  frame_.identity_switched = life_.provisional && observation.agreeing >= kMinOwnFeatures;
  if (frame_.identity_switched || !is_seen || ++life_.rejections < kMaxRejections) {
    return false;
  }
  life_.rejections = 0;
  restart_at_observation(observation, camera);
  return true;
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
  // The path so far was that of another object: nothing known in its frame holds for this one.
  if (is_rigid()) {  // an outline's origin is its centre
    identity_.to_origin_m.setZero();
  }
  const Eigen::Vector3d part_cam_m = position_in_camera(geometry_, observation);
  identity_.filter.restart_at({observation.uvd_px,
                               observation.features,
                               {identity_.to_origin_m, part_covariance(part_cam_m, camera.T_world_cam.rotation)}},
                              camera.T_world_cam);
  identity_.reconstructed = false;
  identity_.area_m2 = identity_.width_m = 0.0;
  motion_.reset();
  box_.reset();
  frame_.change = FrameChange::kReplaced;
}

objects::Bearing ObjectState::mask_bearing(const CameraState& camera) const {
  const PixelBox& box = life_.track.box_px;
  objects::VisiblePart part = visible_part_of(camera.T_world_cam);
  if (!is_rigid()) {
    part.to_origin_m.setZero();  // an outline's origin is its centre
  }
  return {.uv_px = {box.center_x(), box.center_y()}, .center_sigma_m = identity_.width_m, .part = part};
}

objects::VisiblePart ObjectState::visible_part_of(const Se3& T_world_cam) const {
  return {.to_origin_m = identity_.T_world_obj.rotation * identity_.to_origin_m,
          .covariance_m2 = part_covariance(T_world_cam.inverse() * visible_center_m(), T_world_cam.rotation)};
}

Eigen::Matrix3d ObjectState::part_covariance(const Eigen::Vector3d& part_cam_m,
                                             const Eigen::Matrix3d& R_world_cam) const {
  const double depth_m = std::max(part_cam_m.z(), kMinProjectionDepth_m);
  const double sigma_px = is_rigid() ? kObservedDisparitySigma_px : kOutlineDisparitySigma_px;
  const Eigen::Vector3d along_ray_m = geometry_.depth_sigma_m(depth_m, sigma_px) / depth_m * (R_world_cam * part_cam_m);
  return extent_covariance(depth_m) + top_covariance(R_world_cam) + along_ray_m * along_ray_m.transpose();
}

Eigen::Matrix3d ObjectState::top_covariance(const Eigen::Matrix3d& R_world_cam) const {
  const double sigma_m = is_rigid() ? 0.0 : kOutlineTopSigma_m;
  return sigma_m * sigma_m * R_world_cam.col(1) * R_world_cam.col(1).transpose();
}

Eigen::Matrix3d ObjectState::extent_covariance(double depth_m) const {
  const double visible_width_m = life_.track.box_px.width() * std::max(depth_m, 0.0) / geometry_.fx_px;
  // The median of features anywhere on the visible part; an outline is that of the part itself.
  const double features = std::clamp(frame_.observed_features, 1, kMaxSpreadFeatures);
  const double surface_m = is_rigid()
                               ? std::max(surface_sigma_m_, visible_width_m * std::sqrt(kUniformVariance / features))
                               : kOutlineSigma_m;
  return hidden_covariance(visible_width_m) + surface_m * surface_m * Eigen::Matrix3d::Identity();
}

Eigen::Matrix3d ObjectState::hidden_covariance(double visible_width_m) const {
  // The hidden width follows from masks or, where it has just returned, from the width when last seen whole.
  const double hidden_width_m =
      std::max({visible_width_m * (1.0 / visible_part() - 1.0), identity_.width_m - visible_width_m, 0.0});
  const double width_m = hidden_width_m + visible_width_m;
  const double hidden_fraction = is_truncated_or_occluded() || width_m <= 0.0 ? 1.0 : hidden_width_m / width_m;
  Eigen::Vector3d size_m = Eigen::Vector3d::Constant(width_m);
  Eigen::Matrix3d axes = Eigen::Matrix3d::Identity();
  if (box_.known() && is_rigid()) {
    const Box3 box = box_.box_in_object();
    size_m = box.size_m;
    axes = identity_.T_world_obj.rotation * box.rotation();
  }
  const Eigen::Vector3d variance_m2 = kUniformVariance * (hidden_fraction * size_m).cwiseAbs2();
  return axes * variance_m2.asDiagonal() * axes.transpose();
}

void ObjectState::update_status(bool is_located) noexcept {
  if (is_located) {
    life_.predicted.reset();
    life_.status = BodyStatus::kStereoOnly;
    return;
  }
  life_.predicted.add_frame(frame_.interval_ns);
  life_.status = life_.predicted.exceeds(lost_after_ns_) ? BodyStatus::kLost : BodyStatus::kPropagated;
}

}  // namespace kinetrace::pipeline
