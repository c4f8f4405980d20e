#include "object_state.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "box_extent.hpp"
#include "kinetrace/tracking/track_instance.hpp"
#include "kinetrace/trajectory/composition.hpp"

namespace kinetrace::pipeline {
namespace {

// At rest: shown to be slower than this; a lack of evidence of motion is not enough.
constexpr std::size_t kMinRestSamples = 8;  // Of a statistic, so not a time.
constexpr double kMaxRestSpeed_mps = 0.4;
constexpr double kRestSigmas = 2.0;
constexpr double kAreaDecay = 0.97;  // Decay of the recent area in a tenth of a second.
constexpr double kAreaDecayTime_s = 0.1;
constexpr double kNominalDistance_m = 1000.0;  // Nominal: the distance is unknown.
// Disparity errors of one surface are correlated, and change as it comes nearer. Without a reconstruction the measured
// point is the centre of the visible part, which drifts as the object turns and is occluded.
constexpr double kCorrelatedDisparityError_px = 0.03;
constexpr double kLateralCorrelatedError = 0.3;
constexpr double kUnobservedPositionSigma_m = 100.0;

double yaw_of(const Eigen::Vector3d& direction) {
  return std::atan2(-direction.z(), direction.x());
}

}  // namespace

Result<ObjectState> ObjectState::create(const PipelineConfig& config, const StereoGeometry& geometry, Arena& arena) {
  auto body = sfm::BodyReconstruction::create(config.object, geometry, arena);
  if (!body) {
    return Unexpected(body.error());
  }
  return ObjectState(config, geometry, std::move(*body), arena);
}

std::size_t ObjectState::required_bytes(const PipelineConfig& config) {
  return sfm::BodyReconstruction::required_bytes(config.object) + measure_bytes([&](Arena& arena) {
           trajectory::BoxEstimator(config.trajectory.size_table, StereoGeometry{}, arena);
         });
}

ObjectState::ObjectState(const PipelineConfig& config, const StereoGeometry& geometry, sfm::BodyReconstruction body,
                         Arena& arena)
    : config_(config.objects),
      lost_after_ns_(to_ns(config.objects.lost_after_s)),
      surface_sigma_m_(config.trajectory.surface_sigma_m),
      min_points_(config.object.min_inliers),
      min_disparity_px_(config.object.min_disparity_px),
      turn_rate_radps_(config.object.turn_rate_radps),
      found_by_motion_(segmentation::uses_motion(config.segmentation.mode)),
      window_frames_(config.background.window_frames),
      geometry_(geometry),
      identity_(objects::MotionFilter(
          {.prior = config.trajectory.motion, .stereo_sigma_px = config.trajectory.stereo_sigma_px}, geometry)),
      body_(std::move(body)),
      motion_(config.trajectory),
      box_(config.trajectory.size_table, geometry, arena) {}

void ObjectState::begin(const Track& track) {
  identity_.filter.reset();
  identity_ = Identity(identity_.filter);
  life_ = Life{};
  life_.track = track;
  frame_ = Frame{};
  path_restarts_ = false;
  body_.reset();
  motion_.reset();
  box_.reset();
}

void ObjectState::set_dormant(const Track& track) noexcept {
  life_.track = track;
  life_.provisional = false;
  // The detection of this frame showed another object.
  life_.matched_timestamp_ns = life_.timestamp_ns - track.missed_ns;
  identity_.area_m2 = frame_.area_before_m2;
}

void ObjectState::restart_path() noexcept {
  motion_.reset();
  identity_.filter.reset();
  path_restarts_ = true;
  if (!body_.active()) {
    life_.status = BodyStatus::kInitializing;
  }
}

tracking::ObjectPrediction ObjectState::prediction(std::int64_t timestamp_ns, const Se3& T_world_cam) const {
  if (!has_position()) {
    return predict_direction(T_world_cam);
  }
  objects::UncertainPose expected{.T_world_obj = identity_.T_world_obj};
  objects::UncertainPosition part{.position_m = visible_center_m()};
  if (identity_.filter.initialised()) {
    expected = identity_.filter.predicted(timestamp_ns);
    part = identity_.filter.predicted_part(timestamp_ns, visible_part_of(T_world_cam));
  }
  const Eigen::Vector3d p_cam = T_world_cam.inverse() * expected.T_world_obj.translation;
  tracking::ObjectPrediction prediction{true, geometry_.project(p_cam).head<2>(), p_cam.z()};
  const double part_z_m = (T_world_cam.inverse() * part.position_m).z();
  if (part_z_m > kMinProjectionDepth_m) {
    const Eigen::Vector3d forward = T_world_cam.rotation.col(2);
    prediction.disparity_px = geometry_.disparity_px(part_z_m);
    prediction.disparity_sigma_px =
        prediction.disparity_px / part_z_m * std::sqrt(forward.dot(part.covariance * forward));
  }
  if (box_.known()) {
    const Box3 box = box_.box_in_world(expected.T_world_obj);
    const Eigen::Matrix3d covariance = reference_covariance(expected.T_world_obj, expected.covariance);
    prediction.extent = image_extent(box, box_.sigma(), covariance, T_world_cam, geometry_);
    prediction.volume = volume_of(box, box_.sigma(), covariance, T_world_cam, geometry_);
  }
  return prediction;
}

tracking::ObjectPrediction ObjectState::predict_direction(const Se3& T_world_cam) const {
  if (!life_.direction_world) {
    return {};
  }
  const Eigen::Vector3d p_cam = kNominalDistance_m * (T_world_cam.rotation.transpose() * *life_.direction_world);
  return {.known = true, .point_px = geometry_.project(p_cam).head<2>(), .depth_m = p_cam.z(), .direction_only = true};
}

void ObjectState::record_direction(const CameraState& camera) {
  if (life_.track.missed_frames > 0 || life_.track.area_px == 0 || !camera.valid) {
    return;
  }
  const PixelBox& box = life_.track.box_px;
  const Eigen::Vector3d ray(box.center_x(), box.center_y(), 1.0);
  life_.direction_world =
      camera.T_world_cam.rotation *
      Eigen::Vector3d((ray.x() - geometry_.cx_px) / geometry_.fx_px, (ray.y() - geometry_.cy_px) / geometry_.fy_px, 1.0)
          .normalized();
}

void ObjectState::end() {
  life_.ended = true;
  if (body_.active()) {
    body_.end();
  }
}

StereoObservation ObjectState::observe_stereo(const FeatureFrame& frame, LabelView labels,
                                              const CameraState& camera) const {
  StereoObservation observation = pipeline::observe_stereo(frame, life_.track.label(), min_disparity_px_);
  if (!is_rigid() && life_.track.area_px > 0) {
    observe_by_outline(labels, camera, observation);
  }
  return observation;
}

void ObjectState::observe_by_outline(LabelView labels, const CameraState& camera,
                                     StereoObservation& observation) const {
  const PixelBox& box = life_.track.box_px;
  observation.uvd_px.x() = mean_column(labels, box, life_.track.label());
  if (box.y0 > 0) {
    observation.uvd_px.y() = box.y0;
  } else if (identity_.filter.initialised()) {
    observation.uvd_px.y() = geometry_.project(visible_center_in_camera_m(camera)).y();
  }
}

void ObjectState::measure_visible_fraction(const CameraState& camera) {
  frame_.visible_fraction = 1.F;
  frame_.area_before_m2 = identity_.area_m2;
  const double depth_m = visible_center_in_camera_m(camera).z();
  if (!has_position() || life_.track.missed_frames > 0 || is_truncated() || depth_m <= 0.0) {
    return;
  }
  const double m_per_px = depth_m / std::sqrt(geometry_.fx_px * geometry_.fy_px);
  const double area_m2 = life_.track.area_px * m_per_px * m_per_px;
  const double decay = std::pow(kAreaDecay, 1e-9 * static_cast<double>(frame_.interval_ns) / kAreaDecayTime_s);
  identity_.area_m2 = std::max(area_m2, decay * identity_.area_m2);
  frame_.visible_fraction = static_cast<float>(area_m2 / identity_.area_m2);
}

bool ObjectState::initialise_position(const StereoObservation& observation, const CameraState& camera) {
  if (observation.agreeing < config_.stereo_only_min_features || !camera.valid) {
    return false;
  }
  const Eigen::Vector3d observed_m = camera.T_world_cam * position_in_camera(geometry_, observation);
  StereoObservation center = observation;
  if (!is_rigid()) {
    center.uvd_px.y() = 0.5 * (life_.track.box_px.y0 + life_.track.box_px.y1);
  }
  identity_.T_world_obj = {Eigen::Matrix3d::Identity(), camera.T_world_cam * position_in_camera(geometry_, center)};
  identity_.to_origin_m = identity_.T_world_obj.translation - observed_m;
  return true;
}

void ObjectState::reinitialise_filter(const Se3& T_world_obj, const Vector6d& velocity) noexcept {
  if (life_.status == BodyStatus::kTracked) {
    start_filter(T_world_obj, velocity, T_world_obj * life_.T_obj_cam);
  }
}

Eigen::Vector3d ObjectState::velocity_at(const trajectory::MotionEstimate& motion, const Eigen::Vector3d& arm_world_m) {
  return motion.velocity_mps + motion.yaw_rate_rad_s * Eigen::Vector3d::UnitY().cross(arm_world_m);
}

bool ObjectState::at_rest() const noexcept {
  const trajectory::MotionEstimate motion = motion_.at(0);
  return identity_.reconstructed && motion_.size() >= kMinRestSamples && !motion.apparently_moving &&
         motion.velocity_mps.norm() + kRestSigmas * std::sqrt(motion.apparent_covariance.trace()) < kMaxRestSpeed_mps;
}

bool ObjectState::is_in_view() const {
  const Eigen::Vector3d p_cam = life_.T_obj_cam.inverse() * -identity_.to_origin_m;
  const Eigen::Vector3d uv_px = geometry_.project(p_cam);
  return p_cam.z() > 0.0 && uv_px.x() >= 0.0 && uv_px.x() < geometry_.width_px && uv_px.y() >= 0.0 &&
         uv_px.y() < geometry_.height_px;
}

// Motion segmentation finds most objects the moment they move, and some background that never does.
bool ObjectState::is_an_object() const noexcept {
  const bool is_moving_region = found_by_motion_ && life_.track.class_id == kUnknownClass;
  return !is_moving_region || life_.detections >= window_frames_ || (motion_.size() > 0 && motion_.at(0).moving);
}

void ObjectState::begin_frame(const Track& track, std::int64_t timestamp_ns, const CameraState& camera) {
  const bool is_first = life_.frames++ == 0;
  if (track.missed_frames == 0 && life_.track.missed_ns > tracking::kMaxFeatureGap_ns) {
    life_.provisional = true;
  }
  frame_ = Frame{};
  frame_.change = path_restarts_ ? FrameChange::kReplaced : FrameChange::kNone;
  if (!is_first) {
    frame_.interval_ns = timestamp_ns - life_.timestamp_ns;
    frame_.interval_s = 1e-9 * static_cast<double>(frame_.interval_ns);
  }
  path_restarts_ = false;
  life_.track_before = life_.track;
  life_.track = track;
  life_.confirmed = life_.confirmed || (track.state == TrackState::kConfirmed && is_an_object());
  life_.timestamp_ns = timestamp_ns;
  motion_.set_gait(!is_rigid());
  motion_.set_disparity_sigma(camera.disparity_sigma_px);
  motion_.set_vertical(camera.vertical);
  identity_.filter.set_vertical(camera.vertical);
  measure_visible_fraction(camera);
  if (track.missed_frames == 0) {
    life_.matched_timestamp_ns = life_.timestamp_ns;
    ++life_.detections;
  }
}

void ObjectState::observe(const Track& track, const FeatureFrame& frame, LabelView labels, const CameraState& camera) {
  begin_frame(track, frame.timestamp_ns, camera);
  const StereoObservation observation = observe_stereo(frame, labels, camera);
  frame_.observed_features = observation.features;
  if (!has_position() && !initialise_position(observation, camera)) {
    record_direction(camera);
    return;
  }
  if (locate(frame, camera)) {
    life_.status = BodyStatus::kTracked;
    life_.provisional = false;
    life_.predicted.reset();
    identity_.reconstructed = true;
  } else {
    follow(observation, camera);
    if (!frame_.identity_switched && is_rigid() && camera.valid && observation.features >= min_points_ &&
        !(is_mostly_occluded() && identity_.reconstructed)) {
      // Enough points for a reconstruction, but no known ones that fit.
      begin_body(observation, camera);
    }
  }
  if (body_.active()) {
    FeatureFrame own_features = frame;
    if (frame_.identity_switched) {
      own_features.features = {};  // they belong to another object
    }
    body_.extend(own_features, track.label(), camera.valid ? &camera.T_world_cam.rotation : nullptr);
    frame_.extended = true;
  }
  if (life_.status == BodyStatus::kTracked && observation.features > 0) {
    const Se3 T_world_obj = camera.T_world_cam * body_.estimate().T_body_cam.inverse();
    identity_.to_origin_m =
        -(T_world_obj.inverse() * (camera.T_world_cam * position_in_camera(geometry_, observation)));
  }
}

void ObjectState::compose_newest(const CameraState& camera) {
  const BodyEstimate& estimate = body_.estimate();
  life_.T_obj_cam = estimate.T_body_cam;
  const trajectory::PoseWithCovariance world =
      trajectory::compose({camera.T_world_cam, camera.covariance}, {life_.T_obj_cam, estimate.covariance});
  identity_.T_world_obj = world.pose;
  life_.covariance = rotation_position_covariance(world.pose, world.covariance);
}

Eigen::Matrix3d ObjectState::reference_covariance(const Se3& T_world_obj, const Matrix6d& covariance) const {
  Eigen::Matrix<double, 3, 6> to_reference;
  to_reference << Eigen::Matrix3d::Zero(), Eigen::Matrix3d::Identity();
  to_reference.leftCols<3>() = -skew(T_world_obj.rotation * identity_.reference_m);
  return to_reference * covariance * to_reference.transpose();
}

Eigen::Matrix3d ObjectState::position_correlated_covariance() const {
  const Eigen::Vector3d from_camera_m = identity_.T_world_obj.rotation * -life_.T_obj_cam.translation;
  const double depth_m = std::max(life_.T_obj_cam.inverse().translation.z(), 0.0);
  // The less is visible, the fewer points average the error, and the farther the centre is from them.
  const Eigen::Vector3d along_ray_m = kCorrelatedDisparityError_px / visible_part() * depth_m /
                                      (geometry_.fx_px * geometry_.baseline_m) * from_camera_m;
  Eigen::Matrix3d correlated_covariance = along_ray_m * along_ray_m.transpose();
  correlated_covariance.diagonal().array() +=
      kLateralCorrelatedError * kLateralCorrelatedError * along_ray_m.squaredNorm();
  return correlated_covariance;
}

Eigen::Matrix3d ObjectState::part_drift_covariance() const {
  if (identity_.has_moved || life_.status == BodyStatus::kTracked) {
    return Eigen::Matrix3d::Zero();
  }
  // Where its visible part is not measured, an occluder passes or it leaves the image: then it may have drifted
  // anywhere. An outline does not drift.
  if (is_rigid() && !is_measured()) {
    return kUnobservedPositionSigma_m * kUnobservedPositionSigma_m * Eigen::Matrix3d::Identity();
  }
  return extent_covariance(life_.T_obj_cam.inverse().translation.z()) +
         top_covariance(identity_.T_world_obj.rotation * life_.T_obj_cam.rotation);
}

bool ObjectState::is_measured() const noexcept {
  return life_.status == BodyStatus::kTracked ||
         (life_.status == BodyStatus::kStereoOnly && frame_.observed_features >= kMinOwnFeatures);
}

Eigen::Matrix3d ObjectState::covariance_per_disparity(const CameraState& camera) const {
  const Eigen::Vector3d p_cam = life_.T_obj_cam.inverse() * identity_.reference_m;
  if (!camera.T_world_cam_before || frame_.interval_s <= 0.0 || p_cam.z() <= 0.0) {
    return Eigen::Matrix3d::Zero();
  }
  const Eigen::Matrix3d& R_world_cam = camera.T_world_cam.rotation;
  const Eigen::Vector3d velocity_mps =
      (camera.T_world_cam.translation - camera.T_world_cam_before->translation) / frame_.interval_s;
  return trajectory::velocity_per_disparity(R_world_cam * (p_cam / p_cam.z()), R_world_cam.col(2), velocity_mps,
                                            geometry_.disparity_px(p_cam.z()), camera.background_disparity_px);
}

void ObjectState::push_motion(const CameraState& camera) {
  motion_.push({.timestamp_ns = life_.timestamp_ns,
                .T_world_obj = identity_.T_world_obj,
                .position_covariance = reference_covariance(identity_.T_world_obj, life_.covariance),
                .correlated_covariance = position_correlated_covariance(),
                .part_drift_covariance = part_drift_covariance(),
                .detected_moving = life_.track.detected_moving,
                // Where a person is only predicted, the frame says nothing.
                .is_evidence = is_rigid() || identity_.has_moved || life_.status == BodyStatus::kStereoOnly,
                .covariance_per_disparity = covariance_per_disparity(camera)});
  const trajectory::MotionEstimate motion = motion_.at(0);
  identity_.has_moved = identity_.has_moved || motion.apparently_moving;
  if (life_.status == BodyStatus::kTracked) {
    update_moving_probability();
    Vector6d velocity = Vector6d::Zero();
    velocity.tail<3>() = identity_.T_world_obj.rotation.transpose() * motion.velocity_mps;
    start_filter(identity_.T_world_obj, velocity, camera.T_world_cam);
  }
}

void ObjectState::conclude(const BundleSummary& refinement, const CameraState& camera,
                           const trajectory::Ground& ground) {
  if (!has_position()) {
    return;
  }
  if (frame_.extended) {
    body_.conclude(refinement);
  }
  if (life_.status == BodyStatus::kTracked) {
    compose_newest(camera);
  } else {
    life_.T_obj_cam = identity_.T_world_obj.inverse() * camera.T_world_cam;
  }
  const Eigen::Vector3d p_cam = visible_center_in_camera_m(camera);
  if (life_.track.missed_frames == 0 && !is_truncated_or_occluded()) {
    identity_.width_m = life_.track.box_px.width() * p_cam.z() / geometry_.fx_px;
  }
  push_motion(camera);
  update_box(camera, ground);
}

void ObjectState::report(ObjectResult& result) const {
  result.track_id = life_.track.id;
  result.label = life_.track.label();
  result.class_id = life_.track.class_id;
  result.status = life_.status;
  result.T_world_obj = identity_.T_world_obj;
  result.T_obj_cam = life_.T_obj_cam;
  result.covariance = life_.covariance;
  result.box_px = life_.track.box_px;
  result.point_count = static_cast<int>(body_.estimate().points.size());
  result.inliers = life_.status == BodyStatus::kTracked ? body_.estimate().inliers : 0;
}

void ObjectState::revise(std::size_t age, const CameraState& camera, ObjectResult& result) {
  if (result.status == BodyStatus::kTracked && body_.active() && age < body_.history_size()) {
    const FinalisedPose pose = body_.history(age);
    result.T_obj_cam = pose.T_body_cam;
    const trajectory::PoseWithCovariance world =
        trajectory::compose({camera.T_world_cam, camera.covariance}, {pose.T_body_cam, pose.covariance});
    result.T_world_obj = world.pose;
    result.covariance = rotation_position_covariance(world.pose, world.covariance);
  } else {
    result.T_world_obj = camera.T_world_cam * result.T_obj_cam.inverse();
  }
  motion_.revise(age, result.T_world_obj, reference_covariance(result.T_world_obj, result.covariance));
}

void ObjectState::describe_motion(std::size_t age, ObjectResult& result) const {
  if (age > 0 && age >= motion_.size()) {
    return;  // The path has restarted since: the earlier report stands.
  }
  result.box = box_.known() ? box_.box_in_world(result.T_world_obj) : Box3{.center_m = result.T_world_obj.translation};
  result.box_sigma = box_sigma(result);
  const trajectory::MotionEstimate motion = motion_.at(age);
  // Without a reconstruction, a velocity that is not significant is a drift of the visible surface.
  const bool meaningful = result.status == BodyStatus::kTracked || motion.moving;
  result.velocity_mps = meaningful
                            ? velocity_at(motion, result.box.center_m - result.T_world_obj * identity_.reference_m)
                            : Eigen::Vector3d::Zero();
  result.moving = motion.moving;
  result.heading_rad = yaw_of(motion.moving ? motion.velocity_mps : result.box.rotation().col(0));
}

}  // namespace kinetrace::pipeline
