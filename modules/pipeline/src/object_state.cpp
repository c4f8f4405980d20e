#include "object_state.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "kinetrace/trajectory/composition.hpp"

namespace kinetrace::pipeline {
namespace {

// At rest is what has been shown not to be faster than this, not what has not been shown to move.
constexpr std::size_t kMinRestSamples = 8;  // Of a statistic, so not a time.
constexpr double kMaxRestSpeed_mps = 0.4;
constexpr double kRestSigmas = 2.0;
constexpr double kAreaKept = 0.97;  // In a tenth of a second.
constexpr double kAreaKeptIn_s = 0.1;
constexpr double kVeryFar_m = 1000.0;  // Nothing shows how far.
constexpr std::size_t kLately = 5;     // Frames ago: velocity is fitted over as many after it.
// Disparities of one surface err in common, and differently as it comes nearer. Without a reconstruction, what is
// followed is the middle of what is seen, which drifts as the object turns and as others hide it.
constexpr double kCorrelatedDisparityError_px = 0.03;
constexpr double kLateralCorrelatedError = 0.3;
constexpr double kOutlineSigma_m = 0.03;
constexpr int kTellingFeatures = 4;  // Fewer may all lie on something else; they show no new mover.
constexpr double kAnywhere_m = 100.0;
constexpr double kMinVisible = 0.2;

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
           ObjectRecogniser(StereoGeometry{}, arena);
         });
}

ObjectState::ObjectState(const PipelineConfig& config, const StereoGeometry& geometry, sfm::BodyReconstruction body,
                         Arena& arena)
    : config_(config.objects),
      lost_after_ns_(to_ns(config.objects.lost_after_s)),
      surface_sigma_m_(config.trajectory.surface_sigma_m),
      min_points_(config.object.min_inliers),
      min_disparity_px_(config.object.min_disparity_px),
      geometry_(geometry),
      body_(std::move(body)),
      turn_radps2_(config.trajectory.smoothing_turn_radps2),
      turn_rate_radps_(config.object.turn_rate_radps),
      acceleration_mps2_(config.trajectory.smoothing_acceleration_mps2),
      motion_(config.trajectory),
      filter_(config.trajectory, geometry),
      box_(config.trajectory.size_table, geometry, arena),
      recogniser_(geometry, arena) {}

void ObjectState::begin(const Track& track) {
  body_.reset();
  track_ = track;
  confirmed_ = false;
  ended_ = false;
  identity_switched_ = false;
  handed_over_ = false;
  extended_ = false;
  placed_ = false;
  direction_world_.reset();
  matched_run_.reset();
  known_motion_.reset();
  reconstructed_ = false;
  frame_fixed_ = false;
  path_restarts_ = false;
  tracked_.reset();
  tracked_run_.reset();
  rested_ = false;
  has_moved_ = false;
  width_m_ = 0.0;
  area_m2_ = 0.0;
  recogniser_.clear();
  pose_ambiguous_ = false;
  predicted_.reset();
  inconsistency_count_ = 0.0;
  unseen_s_ = 0.0;
  timestamp_ns_ = 0;
  observed_ = false;
  status_ = BodyStatus::kInitializing;
  stereo_offset_m_.setZero();
  reference_m_.setZero();
  motion_.reset();
  filter_.reset();
  box_.reset();
}

void ObjectState::restart_path() noexcept {
  motion_.reset();
  filter_.reset();
  path_restarts_ = true;
  if (!body_.active()) {
    placed_ = false;
    status_ = BodyStatus::kInitializing;
  }
}

tracking::ObjectPrediction ObjectState::prediction(std::int64_t timestamp_ns, const Se3& T_world_cam) const {
  if (!placed_) {
    return predict_direction(T_world_cam);
  }
  const trajectory::MotionEstimate motion = motion_.at(0);
  const double dt_s = 1e-9 * static_cast<double>(timestamp_ns - timestamp_ns_);
  const Eigen::Vector3d velocity_mps =
      filter_.initialised() ? filter_.velocity_mps()
                            : (motion.moving ? motion.velocity_mps : Eigen::Vector3d(Eigen::Vector3d::Zero()));
  const Eigen::Vector3d p_cam = T_world_cam.inverse() * (T_world_obj_.translation + dt_s * velocity_mps);
  return {true, geometry_.project(p_cam).head<2>(), p_cam.z()};
}

tracking::ObjectPrediction ObjectState::predict_direction(const Se3& T_world_cam) const {
  if (!direction_world_) {
    return {};
  }
  const Eigen::Vector3d p_cam = kVeryFar_m * (T_world_cam.rotation.transpose() * *direction_world_);
  return {.known = true, .point_px = geometry_.project(p_cam).head<2>(), .depth_m = p_cam.z(), .direction_only = true};
}

void ObjectState::note_direction(const CameraState& camera) {
  if (track_.missed_frames > 0 || track_.area_px == 0 || !camera.valid) {
    return;
  }
  const PixelBox& box = track_.box_px;
  const Eigen::Vector3d ray(0.5 * (box.x0 + box.x1 - 1), 0.5 * (box.y0 + box.y1 - 1), 1.0);
  direction_world_ = camera.T_world_cam.rotation * Eigen::Vector3d((ray.x() - geometry_.cx_px) / geometry_.fx_px,
                                                                   (ray.y() - geometry_.cy_px) / geometry_.fy_px, 1.0)
                                                       .normalized();
}

void ObjectState::end() {
  ended_ = true;
  if (body_.active()) {
    body_.end();
  }
}

void ObjectState::observe_by_outline(LabelView labels, const CameraState& camera,
                                     StereoObservation& observation) const {
  const PixelBox& box = track_.box_px;
  observation.uvd_px.x() = mean_column(labels, box, track_.label());
  if (box.y0 > 0) {
    observation.uvd_px.y() = box.y0;
  } else if (filter_.initialised()) {
    observation.uvd_px.y() = geometry_.project(camera.T_world_cam.inverse() * filter_.position_m()).y();
  }
}

void ObjectState::measure_visible_fraction(const CameraState& camera) {
  visible_fraction_ = 1.F;
  const double depth_m = (camera.T_world_cam.inverse() * middle_m()).z();
  if (!placed_ || track_.missed_frames > 0 || cut_off() || depth_m <= 0.0) {
    return;
  }
  const double metre_px = depth_m / std::sqrt(geometry_.fx_px * geometry_.fy_px);
  const double area_m2 = track_.area_px * metre_px * metre_px;
  const double kept = std::pow(kAreaKept, 1e-9 * static_cast<double>(interval_ns_) / kAreaKeptIn_s);
  area_m2_ = std::max(area_m2, kept * area_m2_);
  visible_fraction_ = static_cast<float>(area_m2 / area_m2_);
}

bool ObjectState::place(const StereoObservation& observation, const CameraState& camera) {
  if (observation.agreeing < config_.stereo_only_min_features || !camera.valid) {
    return false;
  }
  const Eigen::Vector3d observed_m = camera.T_world_cam * position_in_camera(geometry_, observation);
  StereoObservation middle = observation;
  if (!rigid()) {
    middle.uvd_px.y() = 0.5 * (track_.box_px.y0 + track_.box_px.y1);
  }
  T_world_obj_ = {Eigen::Matrix3d::Identity(), camera.T_world_cam * position_in_camera(geometry_, middle)};
  stereo_offset_m_ = T_world_obj_.translation - observed_m;
  placed_ = true;
  return true;
}

void ObjectState::learn_motion(const Se3& T_world_obj, const Vector6d& velocity) noexcept {
  if (status_ == BodyStatus::kTracked) {
    known_motion_ = KnownMotion{T_world_obj, velocity, motion_.at(0).moving || motion_.at(kLately).moving};
  } else if (known_motion_) {
    known_motion_->T_world_obj = T_world_obj;
  }
}

Eigen::Vector3d ObjectState::velocity_at(const trajectory::MotionEstimate& motion, const Eigen::Vector3d& arm_world_m) {
  return motion.velocity_mps + motion.yaw_rate_rad_s * Eigen::Vector3d::UnitY().cross(arm_world_m);
}

bool ObjectState::shows_no_motion() const noexcept {
  return reconstructed_ && motion_.size() >= kMinRestSamples && !motion_.at(0).moving;
}

bool ObjectState::at_rest() const noexcept {
  const trajectory::MotionEstimate motion = motion_.at(0);
  return shows_no_motion() &&
         motion.velocity_mps.norm() + kRestSigmas * std::sqrt(motion.covariance.trace()) < kMaxRestSpeed_mps;
}

void ObjectState::set_covariance(double rotation_rad2, const Eigen::Matrix3d& position_m2) noexcept {
  covariance_.setZero();
  covariance_.topLeftCorner<3, 3>().diagonal().setConstant(rotation_rad2);
  covariance_.bottomRightCorner<3, 3>() = position_m2;
}

void ObjectState::begin_frame(const Track& track, std::int64_t timestamp_ns, const CameraState& camera) {
  track_ = track;
  confirmed_ = confirmed_ || track.state == TrackState::kConfirmed;
  interval_s_ = timestamp_ns_ > 0 ? 1e-9 * static_cast<double>(timestamp_ns - timestamp_ns_) : 0.0;
  interval_ns_ = observed_ ? timestamp_ns - timestamp_ns_ : kUsualInterval_ns;
  observed_ = true;
  timestamp_ns_ = timestamp_ns;
  extended_ = false;
  frame_change_ = path_restarts_ ? FrameChange::kReplaced : FrameChange::kNone;
  path_restarts_ = false;
  motion_.set_disparity_sigma(camera.disparity_sigma_px);
  correction_.reset();
  measure_visible_fraction(camera);
  if (track.missed_frames == 0) {
    matched_run_.add_frame(interval_ns_);
    matched_timestamp_ns_ = timestamp_ns_;
  } else {
    matched_run_.reset();
  }
}

void ObjectState::observe(const Track& track, const FeatureFrame& frame, LabelView labels, const CameraState& camera,
                          const features::FeatureFrontEnd& front_end) {
  begin_frame(track, frame.timestamp_ns, camera);
  mask_edges_ = mask_edges(labels);
  StereoObservation observation = observe_stereo(frame, labels);
  if (!rigid() && track_.area_px > 0) {
    observe_by_outline(labels, camera, observation);
  }
  observed_features_ = observation.features;
  if (!placed_ && !place(observation, camera)) {
    note_direction(camera);
    return;
  }
  if (locate(frame, camera)) {
    status_ = BodyStatus::kTracked;
    reconstructed_ = true;
    frame_fixed_ = true;
    known_timestamp_ns_ = pose_ambiguous_ ? known_timestamp_ns_ : timestamp_ns_;
    tracked_.add_frame(interval_ns_);
    predicted_.reset();
    unseen_s_ = 0.0;
    if (filter_.initialised()) {
      rested_ = filter_.at_rest();
      tracked_run_.reset();
    }
    tracked_run_.add_frame(interval_ns_);
    filter_.reset();
    if (pose_ambiguous_) {
      resolve_pose(camera, front_end);
    }
  } else {
    follow_without_body(observation, camera);
    if (rigid() && !identity_switched_ && camera.valid && observation.features >= min_points_ &&
        !(mostly_occluded() && reconstructed_)) {
      // Enough points to build on, but none known that fit.
      begin_body(observation, camera, front_end);
    }
  }
  if (body_.active()) {
    body_.extend(frame, track.label(), camera.valid ? &camera.T_world_cam.rotation : nullptr);
    extended_ = true;
  }
  if (status_ == BodyStatus::kTracked && observation.features > 0) {
    const Se3 T_world_obj = camera.T_world_cam * body_.estimate().T_body_cam.inverse();
    stereo_offset_m_ = -(T_world_obj.inverse() * (camera.T_world_cam * position_in_camera(geometry_, observation)));
  }
}

void ObjectState::compose_newest(const CameraState& camera) {
  const BodyEstimate& estimate = body_.estimate();
  T_obj_cam_ = estimate.T_body_cam;
  const trajectory::PoseWithCovariance world =
      trajectory::compose({camera.T_world_cam, camera.covariance}, {T_obj_cam_, estimate.covariance});
  T_world_obj_ = world.pose;
  covariance_ = rotation_position_covariance(world.pose, world.covariance);
}

Eigen::Matrix3d ObjectState::reference_covariance(const Se3& T_world_obj, const Matrix6d& covariance) const {
  Eigen::Matrix<double, 3, 6> to_reference;
  to_reference << Eigen::Matrix3d::Zero(), Eigen::Matrix3d::Identity();
  to_reference.leftCols<3>() = -skew(T_world_obj.rotation * reference_m_);
  return to_reference * covariance * to_reference.transpose();
}

double ObjectState::extent_sigma_m(double depth_m) const {
  const double visible = std::clamp(static_cast<double>(track_.visible_part), kMinVisible, 1.0);
  const double seen_width_m = track_.box_px.width() * depth_m / geometry_.fx_px;
  // Masks tell how much of it is hidden, unless it has just come back; how wide it once was tells then.
  const double hidden_width_m = std::max(seen_width_m * (1.0 / visible - 1.0), width_m_ - seen_width_m);
  return (rigid() ? surface_sigma_m_ : kOutlineSigma_m) + 0.5 * std::max(hidden_width_m, 0.0);
}

Eigen::Matrix3d ObjectState::position_correlated_covariance() const {
  const Eigen::Vector3d from_camera_m = T_world_obj_.rotation * -T_obj_cam_.translation;
  const double depth_m = std::max(T_obj_cam_.inverse().translation.z(), 0.0);
  // The less of it is seen, the fewer points share the error, and the farther its middle is from them.
  const double visible = std::clamp(static_cast<double>(track_.visible_part), kMinVisible, 1.0);
  const Eigen::Vector3d along_ray_m =
      kCorrelatedDisparityError_px / visible * depth_m / (geometry_.fx_px * geometry_.baseline_m) * from_camera_m;
  Eigen::Matrix3d correlated_covariance = along_ray_m * along_ray_m.transpose();
  correlated_covariance.diagonal().array() +=
      kLateralCorrelatedError * kLateralCorrelatedError * along_ray_m.squaredNorm();
  // What is predicted goes on as it went: that shows no new mover either.
  const bool seen =
      status_ == BodyStatus::kTracked || (status_ == BodyStatus::kStereoOnly && observed_features_ >= kTellingFeatures);
  if (!seen && !has_moved_) {
    correlated_covariance.diagonal().array() += kAnywhere_m * kAnywhere_m;
  } else if (status_ == BodyStatus::kStereoOnly) {
    const double surface_m = 0.5 * extent_sigma_m(depth_m);
    correlated_covariance.diagonal().array() += surface_m * surface_m;
  }
  return correlated_covariance;
}

Eigen::Matrix3d ObjectState::covariance_per_disparity(const CameraState& camera) const {
  const Eigen::Vector3d p_cam = T_obj_cam_.inverse() * reference_m_;
  if (!camera.T_world_cam_before || interval_s_ <= 0.0 || p_cam.z() <= 0.0) {
    return Eigen::Matrix3d::Zero();
  }
  const Eigen::Matrix3d& R_world_cam = camera.T_world_cam.rotation;
  const Eigen::Vector3d velocity_mps =
      (camera.T_world_cam.translation - camera.T_world_cam_before->translation) / interval_s_;
  return trajectory::velocity_per_disparity(R_world_cam * (p_cam / p_cam.z()), R_world_cam.col(2), velocity_mps,
                                            geometry_.disparity_px(p_cam.z()), camera.background_disparity_px);
}

void ObjectState::push_motion(const CameraState& camera) {
  motion_.push({timestamp_ns_, T_world_obj_, reference_covariance(T_world_obj_, covariance_),
                position_correlated_covariance(), covariance_per_disparity(camera)});
  previous_timestamp_ns_ = timestamp_ns_;
  const trajectory::MotionEstimate motion = motion_.at(0);
  has_moved_ = has_moved_ || motion.moving;
}

void ObjectState::conclude(const BundleSummary& refinement, const CameraState& camera,
                           const trajectory::Ground& ground) {
  if (!placed_) {
    return;
  }
  if (extended_) {
    body_.conclude(refinement);
  }
  if (status_ == BodyStatus::kTracked) {
    compose_newest(camera);
  } else {
    T_obj_cam_ = T_world_obj_.inverse() * camera.T_world_cam;
  }
  const Eigen::Vector3d p_cam = camera.T_world_cam.inverse() * middle_m();
  const double u_px = geometry_.project(p_cam).x();
  if (track_.missed_frames == 0 && !half_hidden()) {
    width_m_ = track_.box_px.width() * p_cam.z() / geometry_.fx_px;
  }
  if ((track_.missed_frames == 0 && !mostly_occluded()) || motion_.size() == 0) {
    last_seen_m_ = middle_m();
  }
  in_view_ = p_cam.z() > 0.0 && u_px >= 0.0 && u_px < geometry_.width_px;
  push_motion(camera);
  update_box(camera, ground);
}

void ObjectState::report(ObjectResult& result) const {
  result.track_id = track_.id;
  result.label = track_.label();
  result.class_id = track_.class_id;
  result.status = status_;
  result.T_world_obj = T_world_obj_;
  result.T_obj_cam = T_obj_cam_;
  result.covariance = covariance_;
  result.box_px = track_.box_px;
  result.point_count = static_cast<int>(body_.estimate().points.size());
  result.inliers = status_ == BodyStatus::kTracked ? body_.estimate().inliers : 0;
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
  result.box = box_.known() ? box_.box_in_world(result.T_world_obj) : Box3{.center_m = result.T_world_obj.translation};
  result.box_sigma = box_sigma(result);
  if (age > 0 && age >= motion_.size()) {
    return;  // The path has begun anew since: what was reported of the motion before stands.
  }
  const trajectory::MotionEstimate motion = motion_.at(age);
  // Without a reconstruction, a velocity that is not significant is that of the seen surface, not of the object.
  const bool meaningful = result.status == BodyStatus::kTracked || motion.moving;
  result.velocity_mps = meaningful ? velocity_at(motion, result.box.center_m - result.T_world_obj * reference_m_)
                                   : Eigen::Vector3d::Zero();
  result.moving = motion.moving;
  result.heading_rad = yaw_of(motion.moving ? motion.velocity_mps : result.box.rotation().col(0));
}

}  // namespace kinetrace::pipeline
