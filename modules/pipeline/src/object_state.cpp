#include "object_state.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <utility>

#include <Eigen/Cholesky>

#include "kinetrace/trajectory/composition.hpp"

namespace kinetrace::pipeline {
namespace {

constexpr double kHiddenFactor = 4.0;           // Surface wander of an object that is partly outside the image.
constexpr double kReconstructedSigma_m = 0.05;  // Of the position handed to the stereo-only filter by a reconstruction,
constexpr double kRestDrift_mps = 0.02;         // growing like this while something at rest is not seen,
constexpr double kStartSigma_m = 0.5;           // Of the position handed to the stereo-only filter.
constexpr double kVelocityLag_s = 0.3;          // Age of the velocity that a smoothed path ends with.
constexpr double kExpectedFloor_rad = 0.002;    // Error of a smoothed pose itself,
constexpr double kExpectedFloor_m = 0.02;       // and of where it puts the object.
constexpr double kReachableGate = 36.0;         // Chi-square of six numbers.
// At rest is what has been shown not to be faster than this, not what has not been shown to move.
constexpr std::size_t kLeastRestSamples = 8;
constexpr double kMostRestSpeed_mps = 0.4;
constexpr double kRestSigmas = 2.0;
// How far from where it is expected a lost object may be found again: that it stood still or went on is half the truth.
constexpr int kLeastMissedFrames = 2;
constexpr double kReachAtRest_m = 0.8;
constexpr double kReachOfWay = 0.5;
constexpr double kMostReach_m = 3.0;
constexpr double kSightedSigma_px = 0.3;
// A reconstruction scatters no more than the background's, up to reflections and what moves on it. More means that it
// holds on to a wrong relief: seen from afar, a thing with a wrong relief and a wrong rotation looks nearly right.
constexpr std::size_t kSettledBodyFrames = 6;
constexpr double kIllScatter_px = 0.3;
constexpr double kIllScatterRatio = 2.0;
constexpr int kIllFrames = 4;
constexpr float kClearlyVisible = 0.6F;           // What is seen where more is hidden may well be what hides it.
constexpr std::size_t kMaxSightedFeatures = 256;  // Medians over more than this are no better.

double median(std::span<double> values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

Eigen::Vector3d camera_position(const StereoGeometry& geometry, const StereoSighting& sighting) {
  return geometry.triangulate(sighting.uvd_px.x(), sighting.uvd_px.y(), sighting.uvd_px.z());
}

double yaw_of(const Eigen::Vector3d& direction) {
  return std::atan2(-direction.z(), direction.x());
}

}  // namespace

Result<ObjectState> ObjectState::create(const PipelineConfig& config, const StereoGeometry& geometry, Arena& arena) {
  auto body = sfm::BodyReconstruction::create(config.object, geometry, arena);
  if (!body) {
    return tl::unexpected(body.error());
  }
  return ObjectState(config, geometry, std::move(*body), arena);
}

std::size_t ObjectState::required_bytes(const PipelineConfig& config) {
  return sfm::BodyReconstruction::required_bytes(config.object) + measure_bytes([&](Arena& arena) {
           trajectory::BoxEstimator(config.trajectory, static_cast<std::size_t>(config.object.max_points), arena);
         });
}

ObjectState::ObjectState(const PipelineConfig& config, const StereoGeometry& geometry, sfm::BodyReconstruction body,
                         Arena& arena)
    : config_(config.objects),
      surface_sigma_m_(config.trajectory.surface_sigma_m),
      min_points_(config.object.min_inliers),
      min_disparity_px_(config.object.min_disparity_px),
      geometry_(geometry),
      body_(std::move(body)),
      turn_radps2_(config.trajectory.smoothing_turn_radps2),
      acceleration_mps2_(config.trajectory.smoothing_acceleration_mps2),
      motion_(config.trajectory),
      filter_(config.trajectory, geometry),
      box_(config.trajectory, static_cast<std::size_t>(config.object.max_points), arena) {}

void ObjectState::begin(const Track& track) {
  body_.reset();
  track_ = track;
  confirmed_ = false;
  ended_ = false;
  estranged_ = false;
  handed_over_ = false;
  extended_ = false;
  placed_ = false;
  known_motion_.reset();
  reconstructed_ = false;
  frame_fixed_ = false;
  predicted_frames_ = 0;
  unseen_s_ = 0.0;
  status_ = BodyStatus::kInitializing;
  stereo_offset_m_.setZero();
  motion_.reset();
  filter_.reset();
  box_.reset();
}

tracking::Forecast ObjectState::forecast(std::int64_t timestamp_ns, const Se3& T_world_cam) const {
  if (!placed_) {
    return {};
  }
  const trajectory::MotionEstimate motion = motion_.at(0);
  const double dt_s = 1e-9 * static_cast<double>(timestamp_ns - timestamp_ns_);
  const Eigen::Vector3d velocity_mps =
      filter_.initialised() ? filter_.velocity_mps()
                            : (motion.moving ? motion.velocity_mps : Eigen::Vector3d(Eigen::Vector3d::Zero()));
  const Eigen::Vector3d p_cam = T_world_cam.inverse() * (T_world_obj_.translation + dt_s * velocity_mps);
  return {true, geometry_.project(p_cam).head<2>(), p_cam.z()};
}

std::optional<Eigen::Vector3d> ObjectState::sighted_position(const FeatureFrame& frame,
                                                             const CameraState& camera) const {
  const StereoSighting sighting = sight(frame);
  if (sighting.features < config_.stereo_only_min_features || !camera.valid) {
    return std::nullopt;
  }
  return camera.T_world_cam * camera_position(geometry_, sighting);
}

std::optional<double> ObjectState::may_have_gone_to(const Eigen::Vector3d& position_m, std::uint16_t class_id,
                                                    const CameraState& camera) const {
  const bool waits = alive() && confirmed_ && placed_ && track_.missed_frames >= kLeastMissedFrames;
  if (!waits || track_.class_id != class_id) {
    return std::nullopt;
  }
  const Eigen::Vector3d expected_m = filter_.initialised() ? filter_.position_m() : T_world_obj_ * -stereo_offset_m_;
  const double speed_mps = filter_.initialised() ? filter_.velocity_mps().norm() : motion_.at(0).velocity_mps.norm();
  const double unseen_s = 1e-9 * static_cast<double>(timestamp_ns_ - matched_timestamp_ns_);
  const double depth_m = (camera.T_world_cam.inverse() * position_m).z();
  const double depth_sigma_m = kSightedSigma_px * depth_m * depth_m / (geometry_.fx_px * geometry_.baseline_m);
  const double reach_m = kReachAtRest_m + kReachOfWay * speed_mps * unseen_s + 2.0 * depth_sigma_m;
  const double part = (position_m - expected_m).norm() / std::min(reach_m, kMostReach_m);
  return part <= 1.0 ? std::optional<double>(part) : std::nullopt;
}

void ObjectState::continue_from(const ObjectState& earlier, const Eigen::Vector3d& position_m) {
  track_.id = earlier.track_.id;
  confirmed_ = earlier.confirmed_;
  placed_ = true;
  reconstructed_ = earlier.reconstructed_;
  frame_fixed_ = earlier.frame_fixed_;
  stereo_offset_m_ = earlier.stereo_offset_m_;
  T_world_obj_ = earlier.T_world_obj_;
  const bool rested = earlier.filter_.initialised() && earlier.filter_.at_rest();
  if (!rested) {
    T_world_obj_.translation = position_m + T_world_obj_.rotation * stereo_offset_m_;
  }
}

void ObjectState::end() {
  ended_ = true;
  if (body_.active()) {
    body_.end();
  }
}

StereoSighting ObjectState::sight(const FeatureFrame& frame) const {
  std::array<double, kMaxSightedFeatures> u;
  std::array<double, kMaxSightedFeatures> v;
  std::array<double, kMaxSightedFeatures> d;
  std::size_t count = 0;
  for (const Feature& feature : frame.features) {
    if (feature.body == track_.label() && feature.has_right() && double{feature.disparity_px()} >= min_disparity_px_ &&
        count < kMaxSightedFeatures) {
      u[count] = double{feature.left_px.x()};
      v[count] = double{feature.v_px};
      d[count++] = double{feature.disparity_px()};
    }
  }
  StereoSighting sighting;
  sighting.features = static_cast<int>(count);
  if (count > 0) {
    sighting.uvd_px = {median(std::span(u).first(count)), median(std::span(v).first(count)),
                       median(std::span(d).first(count))};
  }
  return sighting;
}

bool ObjectState::place(const StereoSighting& sighting, const CameraState& camera) {
  if (sighting.features < config_.stereo_only_min_features || !camera.valid) {
    return false;
  }
  T_world_obj_ = {Eigen::Matrix3d::Identity(), camera.T_world_cam * camera_position(geometry_, sighting)};
  placed_ = true;
  return true;
}

bool ObjectState::locate(const FeatureFrame& frame, const CameraState& camera) {
  if (rigid() && body_.active() && ill_fitting(camera)) {
    body_.end();
    known_motion_.reset();
  }
  if (!rigid() || !body_.active()) {
    return false;
  }
  const std::optional<sfm::BodyReconstruction::Expectation> expected = expected_pose(camera);
  if (body_.locate(frame, track_.label(), expected ? &*expected : nullptr).status != BodyStatus::kTracked ||
      !camera.valid) {
    return false;
  }
  if (expected && !reachable(*expected)) {
    body_.refuse_pose();
    return false;
  }
  return true;
}

bool ObjectState::ill_fitting(const CameraState& camera) {
  const bool now = status_ == BodyStatus::kTracked && body_.history_size() >= kSettledBodyFrames &&
                   body_.scatter_px() > std::max(kIllScatter_px, kIllScatterRatio * camera.scatter_px);
  ill_fitting_frames_ = now ? ill_fitting_frames_ + 1 : 0;
  if (ill_fitting_frames_ < kIllFrames) {
    return false;
  }
  ill_fitting_frames_ = 0;
  return true;
}

void ObjectState::learn_motion(const Se3& T_world_obj, const Vector6d& velocity) noexcept {
  known_motion_ = KnownMotion{T_world_obj, velocity};
}

std::optional<sfm::BodyReconstruction::Expectation> ObjectState::expected_pose(const CameraState& camera) const {
  if (!known_motion_ || status_ != BodyStatus::kTracked || !camera.valid) {
    return std::nullopt;
  }
  const double dt_s = 1e-9 * static_cast<double>(timestamp_ns_ - previous_timestamp_ns_);
  const Vector6d step = dt_s * known_motion_->velocity;
  const Se3 T_world_obj = known_motion_->T_world_obj * Se3{so3_exp(step.head<3>()), step.tail<3>()};
  const double unseen_s2 = dt_s * (0.5 * dt_s + kVelocityLag_s);
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

bool ObjectState::reachable(const sfm::BodyReconstruction::Expectation& expected) const {
  const BodyEstimate& found = body_.estimate();
  const Vector6d off = left_difference(expected.T_body_cam, found.T_body_cam);
  const Matrix6d spread = expected.covariance + found.covariance;
  return off.dot(spread.ldlt().solve(off)) <= kReachableGate;
}

Eigen::Vector3d ObjectState::reference_m() const {
  return box_.known() ? box_.box_in_object().center_m : Eigen::Vector3d(Eigen::Vector3d::Zero());
}

bool ObjectState::at_rest() const noexcept {
  if (!reconstructed_ || motion_.size() < kLeastRestSamples) {
    return false;
  }
  const trajectory::MotionEstimate motion = motion_.at(0);
  return !motion.moving &&
         motion.velocity_mps.norm() + kRestSigmas * std::sqrt(motion.covariance.trace()) < kMostRestSpeed_mps;
}

void ObjectState::start_filter() {
  // The pose at hand is the last frame's, or this one's at birth.
  const bool known_before = motion_.size() > 0;
  const trajectory::MotionEstimate motion = motion_.at(0);
  // Out of sight, what showed no motion is best looked for where it was.
  const bool stays = reconstructed_ && motion_.size() >= kLeastRestSamples && !motion.moving;
  const bool drifts = known_before && !stays;
  const double sigma_m = reconstructed_ ? kReconstructedSigma_m : kStartSigma_m;
  filter_.start(known_before ? previous_timestamp_ns_ : timestamp_ns_, T_world_obj_ * -stereo_offset_m_,
                drifts ? motion.velocity_mps : Eigen::Vector3d(Eigen::Vector3d::Zero()),
                sigma_m * sigma_m * Eigen::Matrix3d::Identity(), stays);
}

void ObjectState::follow_without_body(const StereoSighting& sighting, const CameraState& camera) {
  if (!filter_.initialised()) {
    start_filter();
  }
  if (status_ == BodyStatus::kLost && sighting.features >= config_.stereo_only_min_features) {
    reconstructed_ = false;  // It is back: what was reconstructed before has left the map long ago.
  }
  if (half_hidden() && reconstructed_ && known_motion_) {
    coast();
    return;
  }
  filter_.predict(timestamp_ns_);
  const double surface_sigma_m = half_hidden() ? kHiddenFactor * surface_sigma_m_ : surface_sigma_m_;
  const trajectory::StereoPositionFilter before = filter_;
  bool seen = sighting.features >= config_.stereo_only_min_features && camera.valid &&
              filter_.update(sighting.uvd_px, sighting.features, camera.T_world_cam, surface_sigma_m);
  if (seen && filter_.jumped() && reconstructed_) {
    filter_ = before;
    estranged_ = true;
    seen = false;
  }
  T_world_obj_.translation = filter_.position_m() + T_world_obj_.rotation * stereo_offset_m_;
  // A rotation that is not measured: about a radian. Where on the object the seen surface lies errs in common over
  // frames: averaging does not make it surer.
  set_covariance(1.0, filter_.position_covariance() + surface_sigma_m * surface_sigma_m * Eigen::Matrix3d::Identity());
  count_prediction(seen);
}

void ObjectState::coast() {
  const double dt_s = 1e-9 * static_cast<double>(timestamp_ns_ - previous_timestamp_ns_);
  const bool at_rest = filter_.at_rest();
  const Vector6d velocity = at_rest ? Vector6d(Vector6d::Zero()) : known_motion_->velocity;
  if (!at_rest) {
    const Vector6d step = dt_s * velocity;
    T_world_obj_ = (known_motion_->T_world_obj * Se3{so3_exp(step.head<3>()), step.tail<3>()}).orthonormalised();
  }
  unseen_s_ += dt_s;
  const double unseen_s2 = unseen_s_ * (0.5 * unseen_s_ + kVelocityLag_s);
  const double turn_rad = kExpectedFloor_rad + turn_radps2_ * unseen_s2;
  const double way_m = kReconstructedSigma_m + (at_rest ? kRestDrift_mps * unseen_s_ : acceleration_mps2_ * unseen_s2);
  const Eigen::Matrix3d spread = way_m * way_m * Eigen::Matrix3d::Identity();
  filter_.start(timestamp_ns_, T_world_obj_ * -stereo_offset_m_, T_world_obj_.rotation * velocity.tail<3>(), spread,
                at_rest);
  set_covariance(turn_rad * turn_rad, spread);
  count_prediction(false);
}

void ObjectState::set_covariance(double rotation_rad2, const Eigen::Matrix3d& position_m2) noexcept {
  covariance_.setZero();
  covariance_.topLeftCorner<3, 3>().diagonal().setConstant(rotation_rad2);
  covariance_.bottomRightCorner<3, 3>() = position_m2;
}

void ObjectState::count_prediction(bool seen) noexcept {
  predicted_frames_ = seen ? 0 : predicted_frames_ + 1;
  unseen_s_ = seen ? 0.0 : unseen_s_;
  status_ = seen ? BodyStatus::kStereoOnly
                 : (predicted_frames_ > config_.lost_after_frames ? BodyStatus::kLost : BodyStatus::kPropagated);
}

void ObjectState::observe(const Track& track, const FeatureFrame& frame, const CameraState& camera) {
  track_ = track;
  confirmed_ = confirmed_ || track.state == TrackState::kConfirmed;
  timestamp_ns_ = frame.timestamp_ns;
  extended_ = false;
  matched_timestamp_ns_ = track.missed_frames == 0 ? timestamp_ns_ : matched_timestamp_ns_;
  const StereoSighting sighting = sight(frame);
  if (!placed_ && !place(sighting, camera)) {
    return;
  }
  if (locate(frame, camera)) {
    status_ = BodyStatus::kTracked;
    reconstructed_ = true;
    frame_fixed_ = true;
    predicted_frames_ = 0;
    unseen_s_ = 0.0;
    filter_.reset();
  } else {
    follow_without_body(sighting, camera);
    if (rigid() && !estranged_ && camera.valid && sighting.features >= min_points_ &&
        !(half_hidden() && reconstructed_)) {
      // Enough points to build on, but none known that fit: the reconstruction (re)starts where stereo sees the object.
      if (!frame_fixed_) {
        // What stereo has followed so far may have been something next to the object; its frame belongs on its points.
        T_world_obj_.translation = camera.T_world_cam * camera_position(geometry_, sighting);
        stereo_offset_m_.setZero();
      }
      body_.begin(T_world_obj_.inverse() * camera.T_world_cam, status_);
    }
  }
  if (body_.active()) {
    body_.extend(frame, track.label());
    extended_ = true;
  }
  if (status_ == BodyStatus::kTracked && sighting.features > 0) {
    const Se3 T_world_obj = camera.T_world_cam * body_.estimate().T_body_cam.inverse();
    stereo_offset_m_ = -(T_world_obj.inverse() * (camera.T_world_cam * camera_position(geometry_, sighting)));
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
  to_reference.leftCols<3>() = -skew(T_world_obj.rotation * reference_m());
  return to_reference * covariance * to_reference.transpose();
}

void ObjectState::push_motion() {
  motion_.push({timestamp_ns_, T_world_obj_, reference_covariance(T_world_obj_, covariance_)});
  previous_timestamp_ns_ = timestamp_ns_;
  const trajectory::MotionEstimate motion = motion_.at(0);
  const double yaw_rad = motion.moving ? yaw_of(T_world_obj_.rotation.transpose() * motion.velocity_mps)
                                       : std::numeric_limits<double>::quiet_NaN();
  if (body_.active()) {
    box_.update(body_.estimate().points, yaw_rad);
  }
  if (box_.known()) {
    motion_.set_reference(box_.box_in_object().center_m);
  }
}

void ObjectState::conclude(const BundleSummary& refinement, const CameraState& camera) {
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
  const Eigen::Vector3d p_cam = camera.T_world_cam.inverse() * (T_world_obj_ * -stereo_offset_m_);
  const double u_px = geometry_.project(p_cam).x();
  in_view_ = p_cam.z() > 0.0 && u_px >= 0.0 && u_px < geometry_.width_px;
  push_motion();
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
    const SettledPose pose = body_.history(age);
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
  const trajectory::MotionEstimate motion = motion_.at(age);
  // Without a reconstruction, a velocity that is not significant is that of the seen surface, not of the object.
  const bool meaningful = result.status == BodyStatus::kTracked || motion.moving;
  result.velocity_mps = meaningful ? motion.velocity_mps : Eigen::Vector3d(Eigen::Vector3d::Zero());
  result.moving = motion.moving;
  result.box = box_.known() ? box_.box_in_world(result.T_world_obj) : Box3{.center_m = result.T_world_obj.translation};
  result.heading_rad = motion.moving ? yaw_of(motion.velocity_mps) : result.box.yaw_rad;
}

}  // namespace kinetrace::pipeline
