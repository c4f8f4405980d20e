#include "object_state.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <utility>

#include <Eigen/Cholesky>

#include "box_offset.hpp"
#include "kinetrace/trajectory/composition.hpp"

namespace kinetrace::pipeline {
namespace {

constexpr double kHiddenFactor = 4.0;           // Surface wander of an object that is partly outside the image.
constexpr double kReconstructedSigma_m = 0.05;  // Of the position handed to the stereo-only filter by a reconstruction,
constexpr double kRestDrift_mps = 0.02;         // growing like this while something at rest is not seen,
constexpr double kStartSigma_m = 0.5;           // Of the position handed to the stereo-only filter.
// Of a guess where it has come back, however long it was away: it goes on as it went, and turns little.
constexpr double kGuessTurn_rad = 0.05;
constexpr double kGuessPlace_m = 0.27;
constexpr double kVelocityLag_s = 0.3;        // Age of the velocity that a smoothed path ends with.
constexpr double kExpectedFloor_rad = 0.002;  // Error of a smoothed pose itself,
constexpr double kExpectedFloor_m = 0.02;     // and of where it puts the object.
constexpr double kReachableGate = 36.0;       // Chi-square of six numbers.
constexpr double kUnanimousPart = 0.9;        // So many of its points cannot all have passed to something else.
// At rest is what has been shown not to be faster than this, not what has not been shown to move.
constexpr std::size_t kLeastRestSamples = 8;
constexpr double kMostRestSpeed_mps = 0.4;
constexpr double kRestSigmas = 2.0;
// How far from where it is expected a lost object may be found again: that it stood still or went on is half the truth.
// Where it should be in plain sight, a detection has only been missed, and what appears beside it is something else.
constexpr int kLeastMissedInSight = 4;
constexpr int kLeastMissedHidden = 1;
constexpr double kReachAtRest_m = 0.8;
constexpr double kReachOfWay = 0.5;
constexpr double kMostReach_m = 3.0;
// What has only a direction is found within so much of it, and more as the camera goes on.
constexpr double kDirectionReach_px = 8.0;
constexpr double kDirectionDrift_px = 1.0;
constexpr double kSightedSigma_px = 0.3;
constexpr int kSureOfItsMask = 5;      // Frames matched in a row: where it is may be wrong, what it is is not.
constexpr double kAreaKept = 0.97;     // From frame to frame.
constexpr double kFarOffIt_m = 2.0;    // An origin farther from the middle of what is seen is on something else.
constexpr double kVeryFar_m = 1000.0;  // Nothing shows how far.
constexpr int kMostUnsureFrames = 15;
constexpr std::size_t kLately = 5;  // Frames ago.
// Disparities of one surface err in common, and differently as it comes nearer. Without a reconstruction, what is
// followed is the middle of what is seen, which wanders as the object turns and as others hide it.
constexpr double kDisparityWander_px = 0.03;
constexpr double kSidewaysWander = 0.3;
constexpr double kOutlineSigma_m = 0.03;
constexpr int kTellingFeatures = 4;  // Fewer may all lie on something else; they show no new mover.
constexpr double kAnywhere_m = 100.0;
constexpr double kLeastVisible = 0.2;
// A reconstruction scatters no more than the background's, up to reflections and what moves on it. More means that it
// holds on to a wrong relief: seen from afar, a thing with a wrong relief and a wrong rotation looks nearly right.
constexpr double kIllScatter_px = 0.3;
constexpr double kIllScatterRatio = 2.0;
constexpr int kIllFrames = 4;
constexpr double kElsewhereSigmas = 3.0;
constexpr double kMostContradictions = 3.0;  // Then what was reconstructed is not what is seen.
constexpr int kSettledScatterFrames = 6;

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
           trajectory::BoxEstimator(config.trajectory, static_cast<std::size_t>(config.object.max_points), arena);
           ObjectRecogniser(StereoGeometry{}, arena);
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
      turn_rate_radps_(config.object.turn_rate_radps),
      acceleration_mps2_(config.trajectory.smoothing_acceleration_mps2),
      motion_(config.trajectory),
      filter_(config.trajectory, geometry),
      box_(config.trajectory, static_cast<std::size_t>(config.object.max_points), arena),
      recogniser_(geometry, arena) {}

void ObjectState::begin(const Track& track) {
  body_.reset();
  track_ = track;
  confirmed_ = false;
  ended_ = false;
  estranged_ = false;
  handed_over_ = false;
  extended_ = false;
  placed_ = false;
  direction_world_.reset();
  matched_run_ = 0;
  known_motion_.reset();
  reconstructed_ = false;
  frame_fixed_ = false;
  tracked_frames_ = 0;
  has_moved_ = false;
  width_m_ = 0.0;
  area_m2_ = 0.0;
  recogniser_.clear();
  unsure_ = false;
  predicted_frames_ = 0;
  contradictions_ = 0.0;
  unseen_s_ = 0.0;
  status_ = BodyStatus::kInitializing;
  stereo_offset_m_.setZero();
  motion_.reset();
  filter_.reset();
  box_.reset();
}

tracking::Forecast ObjectState::forecast(std::int64_t timestamp_ns, const Se3& T_world_cam) const {
  if (!placed_) {
    return forecast_direction(T_world_cam);
  }
  const trajectory::MotionEstimate motion = motion_.at(0);
  const double dt_s = 1e-9 * static_cast<double>(timestamp_ns - timestamp_ns_);
  const Eigen::Vector3d velocity_mps =
      filter_.initialised() ? filter_.velocity_mps()
                            : (motion.moving ? motion.velocity_mps : Eigen::Vector3d(Eigen::Vector3d::Zero()));
  const Eigen::Vector3d p_cam = T_world_cam.inverse() * (T_world_obj_.translation + dt_s * velocity_mps);
  return {true, geometry_.project(p_cam).head<2>(), p_cam.z()};
}

tracking::Forecast ObjectState::forecast_direction(const Se3& T_world_cam) const {
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

std::optional<Eigen::Vector3d> ObjectState::sighted_position(const FeatureFrame& frame, LabelView labels,
                                                             const CameraState& camera) const {
  const StereoSighting sighting = sight(frame, labels);
  if (sighting.features < config_.stereo_only_min_features || !camera.valid) {
    return std::nullopt;
  }
  return camera.T_world_cam * position_in_camera(geometry_, sighting);
}

Eigen::Vector3d ObjectState::off_body(const Eigen::Vector3d& sighted_m, const Eigen::Vector3d& middle_m) const {
  Eigen::Vector3d off_m = sighted_m - middle_m;
  if (!box_.known()) {
    return off_m;
  }
  const Eigen::Matrix3d& R_world_obj = T_world_obj_.rotation;
  const Eigen::Vector3d outside_m =
      R_world_obj * outside_of(box_.box_in_object(), R_world_obj.transpose() * off_m - stereo_offset_m_);
  return outside_m.norm() < off_m.norm() ? outside_m : off_m;
}

std::optional<double> ObjectState::may_have_gone_to(const Eigen::Vector3d& position_m, std::uint16_t class_id,
                                                    const CameraState& camera) const {
  const bool hidden = !in_view_ || mostly_covered();
  const bool waits =
      alive() && confirmed_ && placed_ && track_.missed_frames >= (hidden ? kLeastMissedHidden : kLeastMissedInSight);
  if (!waits || track_.class_id != class_id) {
    return std::nullopt;
  }
  const Eigen::Vector3d expected_m = filter_.initialised() ? filter_.position_m() : T_world_obj_ * -stereo_offset_m_;
  // It may have stopped as well as gone on.
  const Eigen::Vector3d way_m = expected_m - last_seen_m_;
  const double gone = way_m.squaredNorm() > 0.0
                          ? std::clamp((position_m - last_seen_m_).dot(way_m) / way_m.squaredNorm(), 0.0, 1.0)
                          : 0.0;
  const Eigen::Vector3d nearest_m = last_seen_m_ + gone * way_m;
  const double speed_mps = filter_.initialised() ? filter_.velocity_mps().norm() : motion_.at(0).velocity_mps.norm();
  const double unseen_s = 1e-9 * static_cast<double>(timestamp_ns_ - matched_timestamp_ns_);
  const double depth_m = (camera.T_world_cam.inverse() * position_m).z();
  // Of what is half hidden when it goes and when it comes, the middle may lie anywhere on it.
  const double reach_m =
      std::min(std::max(kReachAtRest_m, width_m_) + kReachOfWay * speed_mps * unseen_s, kMostReach_m);
  // Depth is as unsure as its square.
  const Eigen::Vector3d off_m = camera.T_world_cam.rotation.transpose() * off_body(position_m, nearest_m);
  const double part =
      std::hypot(off_m.head<2>().norm() / reach_m, off_m.z() / (reach_m + 2.0 * depth_sigma_m(depth_m)));
  return part <= 1.0 ? std::optional<double>(part) : std::nullopt;
}

std::optional<double> ObjectState::may_be_seen_in(const PixelBox& box_px, std::uint16_t class_id,
                                                  const CameraState& camera) const {
  const tracking::Forecast expected = forecast_direction(camera.T_world_cam);
  const bool waits = alive() && confirmed_ && !placed_ && expected.known && track_.missed_frames >= kLeastMissedInSight;
  if (!waits || track_.class_id != class_id || expected.depth_m <= 0.0) {
    return std::nullopt;
  }
  const Eigen::Vector2d low(box_px.x0, box_px.y0);
  const Eigen::Vector2d high(box_px.x1 - 1, box_px.y1 - 1);
  const double gap_px = (expected.point_px - expected.point_px.cwiseMax(low).cwiseMin(high)).norm();
  const double part = gap_px / (kDirectionReach_px + kDirectionDrift_px * track_.missed_frames);
  return part <= 1.0 ? std::optional<double>(part) : std::nullopt;
}

void ObjectState::continue_from(ObjectState& earlier, const std::optional<Eigen::Vector3d>& position_m) {
  track_.id = earlier.track_.id;
  confirmed_ = earlier.confirmed_;
  if (!earlier.placed_ || !position_m) {
    return;  // Nothing but its name is known.
  }
  placed_ = true;
  reconstructed_ = earlier.reconstructed_;
  frame_fixed_ = earlier.frame_fixed_;
  tracked_frames_ = earlier.tracked_frames_;
  known_timestamp_ns_ = earlier.known_timestamp_ns_;
  has_moved_ = earlier.has_moved_;
  width_m_ = earlier.width_m_;
  recogniser_.swap(earlier.recogniser_);
  std::swap(box_, earlier.box_);
  stereo_offset_m_ = earlier.stereo_offset_m_;
  T_world_obj_ = earlier.T_world_obj_;
  if (earlier.filter_.initialised()) {
    // Where it was expected, and how surely, is weighed against the middle of what is seen of it now.
    filter_ = earlier.filter_;
    known_motion_ = earlier.known_motion_;
    unseen_s_ = earlier.unseen_s_;
    previous_timestamp_ns_ = earlier.previous_timestamp_ns_;
    if (filter_.at_rest()) {
      known_motion_ = KnownMotion{T_world_obj_, Vector6d::Zero(), false};
    }
  } else {
    T_world_obj_.translation = *position_m + T_world_obj_.rotation * stereo_offset_m_;
  }
}

void ObjectState::end() {
  ended_ = true;
  if (body_.active()) {
    body_.end();
  }
}

void ObjectState::sight_by_outline(LabelView labels, const CameraState& camera, StereoSighting& sighting) const {
  const PixelBox& box = track_.box_px;
  sighting.uvd_px.x() = mean_column(labels, box, track_.label());
  if (box.y0 > 0) {
    sighting.uvd_px.y() = box.y0;
  } else if (filter_.initialised()) {
    sighting.uvd_px.y() = geometry_.project(camera.T_world_cam.inverse() * filter_.position_m()).y();
  }
}

void ObjectState::measure_uncovered_part(const CameraState& camera) {
  uncovered_part_ = 1.F;
  const double depth_m = (camera.T_world_cam.inverse() * (T_world_obj_ * -stereo_offset_m_)).z();
  if (!placed_ || track_.missed_frames > 0 || cut_off() || depth_m <= 0.0) {
    return;
  }
  const double metre_px = depth_m / std::sqrt(geometry_.fx_px * geometry_.fy_px);
  const double area_m2 = track_.area_px * metre_px * metre_px;
  area_m2_ = std::max(area_m2, kAreaKept * area_m2_);
  uncovered_part_ = static_cast<float>(area_m2 / area_m2_);
}

bool ObjectState::place(const StereoSighting& sighting, const CameraState& camera) {
  if (sighting.features < config_.stereo_only_min_features || !camera.valid) {
    return false;
  }
  const Eigen::Vector3d sighted_m = camera.T_world_cam * position_in_camera(geometry_, sighting);
  StereoSighting middle = sighting;
  if (!rigid()) {
    middle.uvd_px.y() = 0.5 * (track_.box_px.y0 + track_.box_px.y1);
  }
  T_world_obj_ = {Eigen::Matrix3d::Identity(), camera.T_world_cam * position_in_camera(geometry_, middle)};
  stereo_offset_m_ = T_world_obj_.translation - sighted_m;
  placed_ = true;
  return true;
}

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

void ObjectState::learn_motion(const Se3& T_world_obj, const Vector6d& velocity) noexcept {
  if (status_ == BodyStatus::kTracked) {
    known_motion_ = KnownMotion{T_world_obj, velocity, motion_.at(0).moving || motion_.at(kLately).moving};
  } else if (known_motion_) {
    known_motion_->T_world_obj = T_world_obj;
  }
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

Eigen::Vector3d ObjectState::reference_m() const {
  return box_.known() ? box_.box_in_object().center_m : Eigen::Vector3d(Eigen::Vector3d::Zero());
}

bool ObjectState::shows_no_motion() const noexcept {
  return reconstructed_ && motion_.size() >= kLeastRestSamples && !motion_.at(0).moving;
}

bool ObjectState::at_rest() const noexcept {
  const trajectory::MotionEstimate motion = motion_.at(0);
  return shows_no_motion() &&
         motion.velocity_mps.norm() + kRestSigmas * std::sqrt(motion.covariance.trace()) < kMostRestSpeed_mps;
}

void ObjectState::start_filter() {
  // The pose at hand is the last frame's, or this one's at birth.
  const bool known_before = motion_.size() > 0;
  const trajectory::MotionEstimate motion = motion_.at(0);
  // Its last poses may be too unsure to show a motion that was well known before.
  const bool goes_on = known_motion_ && known_motion_->moving;
  // Out of sight, what showed no motion is best looked for where it was.
  const bool stays = shows_no_motion() && !goes_on;
  Eigen::Vector3d velocity_mps = Eigen::Vector3d::Zero();
  if (motion.moving) {
    velocity_mps = motion.velocity_mps;
  } else if (goes_on) {
    velocity_mps = T_world_obj_.rotation * known_motion_->velocity.tail<3>();
  }
  const double sigma_m = reconstructed_ ? kReconstructedSigma_m : kStartSigma_m;
  filter_.start(known_before ? previous_timestamp_ns_ : timestamp_ns_, T_world_obj_ * -stereo_offset_m_, velocity_mps,
                sigma_m * sigma_m * Eigen::Matrix3d::Identity(), stays);
}

void ObjectState::follow_without_body(const StereoSighting& sighting, const CameraState& camera) {
  if (!filter_.initialised()) {
    start_filter();
  }
  if (status_ == BodyStatus::kLost && !filter_.at_rest() && sighting.features >= config_.stereo_only_min_features) {
    reconstructed_ = false;  // It is back: what was reconstructed before has left the map long ago.
  }
  const double depth_m = sighting.features > 0 ? position_in_camera(geometry_, sighting).z() : 0.0;
  if (known_motion_ && seen_elsewhere(sighting, camera)) {
    known_motion_.reset();
  }
  if (reconstructed_ && known_motion_ &&
      (mostly_covered() ||
       (cut_off() && well_known() && (sighting.features == 0 || coasting_sigma_m() < surface_wander_m(depth_m))))) {
    coast();
    return;
  }
  filter_.predict(timestamp_ns_);
  const double surface_sigma_m =
      std::max(surface_wander_m(depth_m), half_hidden() ? kHiddenFactor * surface_sigma_m_ : 0.0);
  const trajectory::StereoPositionFilter before = filter_;
  bool seen = sighting.features >= config_.stereo_only_min_features && camera.valid &&
              filter_.update(part_seen(sighting, camera), sighting.features, camera.T_world_cam, surface_sigma_m);
  if (sighting.features < config_.stereo_only_min_features && track_.missed_frames == 0 && camera.valid &&
      !filter_.at_rest()) {
    const PixelBox& box = track_.box_px;
    filter_.update_direction({0.5 * (box.x0 + box.x1 - 1), 0.5 * (box.y0 + box.y1 - 1)}, camera.T_world_cam,
                             std::max(surface_sigma_m, width_m_));
  }
  const bool still_there =
      seen && before.at_rest() && reconstructed_ && (!filter_.jumped() || lies_on_it(sighting, camera));
  if (still_there) {
    // The middle of what is seen of it says that it is still there, but not better than its reconstruction where.
    filter_ = before;
  }
  if (seen && !still_there && filter_.jumped() && reconstructed_ && matched_run_ < kSureOfItsMask) {
    filter_ = before;
    estranged_ = true;
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

bool ObjectState::seen_elsewhere(const StereoSighting& sighting, const CameraState& camera) const {
  if (sighting.features < 2 * min_points_ || !camera.valid) {
    return false;
  }
  const Eigen::Vector3d sighted_cam_m = position_in_camera(geometry_, sighting);
  const double off_m = off_body(camera.T_world_cam * sighted_cam_m, coasted() * -stereo_offset_m_).norm();
  const double depth_m = sighted_cam_m.z();
  const double sigma_m = std::hypot(coasting_sigma_m(), surface_wander_m(depth_m), depth_sigma_m(depth_m));
  return off_m > kElsewhereSigmas * sigma_m;
}

Eigen::Vector3d ObjectState::part_seen(const StereoSighting& sighting, const CameraState& camera) const {
  if (!reconstructed_ || !half_hidden()) {
    return sighting.uvd_px;
  }
  const Eigen::Vector3d sighted_m = camera.T_world_cam * position_in_camera(geometry_, sighting);
  const Eigen::Vector3d p_cam =
      camera.T_world_cam.inverse() * (filter_.position_m() + off_body(sighted_m, filter_.position_m()));
  if (p_cam.z() <= 0.0) {
    return sighting.uvd_px;
  }
  const Eigen::Vector3d uvr_px = geometry_.project(p_cam);
  return {uvr_px.x(), uvr_px.y(), uvr_px.x() - uvr_px.z()};
}

bool ObjectState::lies_on_it(const StereoSighting& sighting, const CameraState& camera) const {
  const Eigen::Vector3d sighted_m = camera.T_world_cam * position_in_camera(geometry_, sighting);
  const Eigen::Vector3d off_m =
      camera.T_world_cam.rotation.transpose() * off_body(sighted_m, T_world_obj_ * -stereo_offset_m_);
  const double depth_m = (camera.T_world_cam.inverse() * sighted_m).z();
  return off_m.head<2>().norm() <= kReachAtRest_m &&
         std::abs(off_m.z()) <= kReachAtRest_m + 2.0 * depth_sigma_m(depth_m);
}

double ObjectState::depth_sigma_m(double depth_m) const {
  return kSightedSigma_px * depth_m * depth_m / (geometry_.fx_px * geometry_.baseline_m);
}

double ObjectState::coasting_sigma_m() const {
  const double unseen_s2 = unseen_s_ * (0.5 * unseen_s_ + kVelocityLag_s);
  return kReconstructedSigma_m + (filter_.at_rest() ? kRestDrift_mps * unseen_s_ : acceleration_mps2_ * unseen_s2);
}

bool ObjectState::goes_on() const noexcept {
  return !filter_.at_rest() && known_motion_->moving;
}

Se3 ObjectState::coasted() const {
  if (!goes_on()) {
    return T_world_obj_;
  }
  const double dt_s = 1e-9 * static_cast<double>(timestamp_ns_ - previous_timestamp_ns_);
  const Vector6d& velocity = known_motion_->velocity;
  // A slower turn is as well the noise of its last poses, and adds up in what is not seen.
  const bool turns = velocity.head<3>().norm() > turn_rate_radps_;
  const Eigen::Vector3d turn_rad = turns ? Eigen::Vector3d(dt_s * velocity.head<3>()) : Eigen::Vector3d::Zero();
  return (known_motion_->T_world_obj * Se3{so3_exp(turn_rad), dt_s * velocity.tail<3>()}).orthonormalised();
}

void ObjectState::coast() {
  const double dt_s = 1e-9 * static_cast<double>(timestamp_ns_ - previous_timestamp_ns_);
  const bool at_rest = filter_.at_rest();
  const Vector6d velocity = goes_on() ? known_motion_->velocity : Vector6d(Vector6d::Zero());
  T_world_obj_ = coasted();
  known_motion_->T_world_obj = goes_on() ? T_world_obj_ : known_motion_->T_world_obj;
  unseen_s_ += dt_s;
  const double unseen_s2 = unseen_s_ * (0.5 * unseen_s_ + kVelocityLag_s);
  const double turn_rad = kExpectedFloor_rad + turn_radps2_ * unseen_s2;
  const double way_m = coasting_sigma_m();
  const Eigen::Matrix3d spread = way_m * way_m * Eigen::Matrix3d::Identity();
  filter_.start(timestamp_ns_, T_world_obj_ * -stereo_offset_m_, T_world_obj_.rotation * velocity.tail<3>(), spread,
                at_rest);
  set_covariance(turn_rad * turn_rad, spread);
  // What stood still and is detected where it was is not lost, however little of it is seen.
  predicted_frames_ = at_rest && track_.missed_frames == 0 ? 0 : predicted_frames_;
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

bool ObjectState::recognise(const CameraState& camera, const features::FeatureFrontEnd& front_end) {
  const double unknown_s = 1e-9 * static_cast<double>(timestamp_ns_ - known_timestamp_ns_);
  const double unknown_s2 = unknown_s * (0.5 * unknown_s + kVelocityLag_s);
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
  } else if (++unsure_frames_ > kMostUnsureFrames) {
    unsure_ = false;  // It looks too different by now: the guess stands.
  }
}

void ObjectState::observe(const Track& track, const FeatureFrame& frame, LabelView labels, const CameraState& camera,
                          const features::FeatureFrontEnd& front_end) {
  track_ = track;
  confirmed_ = confirmed_ || track.state == TrackState::kConfirmed;
  timestamp_ns_ = frame.timestamp_ns;
  extended_ = false;
  frame_change_ = FrameChange::kNone;
  correction_.reset();
  measure_uncovered_part(camera);
  matched_run_ = track.missed_frames == 0 ? matched_run_ + 1 : 0;
  matched_timestamp_ns_ = track.missed_frames == 0 ? timestamp_ns_ : matched_timestamp_ns_;
  StereoSighting sighting = sight(frame, labels);
  if (!rigid() && track_.area_px > 0) {
    sight_by_outline(labels, camera, sighting);
  }
  sighted_features_ = sighting.features;
  if (!placed_ && !place(sighting, camera)) {
    note_direction(camera);
    return;
  }
  if (locate(frame, camera)) {
    status_ = BodyStatus::kTracked;
    reconstructed_ = true;
    frame_fixed_ = true;
    known_timestamp_ns_ = unsure_ ? known_timestamp_ns_ : timestamp_ns_;
    ++tracked_frames_;
    predicted_frames_ = 0;
    unseen_s_ = 0.0;
    filter_.reset();
    if (unsure_) {
      make_sure(camera, front_end);
    }
  } else {
    follow_without_body(sighting, camera);
    if (rigid() && !estranged_ && camera.valid && sighting.features >= min_points_ &&
        !(mostly_covered() && reconstructed_)) {
      // Enough points to build on, but none known that fit.
      begin_body(sighting, camera, front_end);
    }
  }
  if (body_.active()) {
    body_.extend(frame, track.label(), camera.valid ? &camera.T_world_cam.rotation : nullptr);
    extended_ = true;
  }
  if (status_ == BodyStatus::kTracked && sighting.features > 0) {
    const Se3 T_world_obj = camera.T_world_cam * body_.estimate().T_body_cam.inverse();
    stereo_offset_m_ = -(T_world_obj.inverse() * (camera.T_world_cam * position_in_camera(geometry_, sighting)));
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

double ObjectState::surface_wander_m(double depth_m) const {
  const double visible = std::clamp(static_cast<double>(track_.visible_part), kLeastVisible, 1.0);
  const double seen_width_m = track_.box_px.width() * depth_m / geometry_.fx_px;
  // Masks tell how much of it is hidden, unless it has just come back; how wide it once was tells then.
  const double hidden_width_m = std::max(seen_width_m * (1.0 / visible - 1.0), width_m_ - seen_width_m);
  return (rigid() ? surface_sigma_m_ : kOutlineSigma_m) + 0.5 * std::max(hidden_width_m, 0.0);
}

Eigen::Matrix3d ObjectState::position_wander() const {
  const Eigen::Vector3d from_camera_m = T_world_obj_.rotation * -T_obj_cam_.translation;
  const double depth_m = std::max(T_obj_cam_.inverse().translation.z(), 0.0);
  // The less of it is seen, the fewer points share the error, and the farther its middle is from them.
  const double visible = std::clamp(static_cast<double>(track_.visible_part), kLeastVisible, 1.0);
  const Eigen::Vector3d along_ray_m =
      kDisparityWander_px / visible * depth_m / (geometry_.fx_px * geometry_.baseline_m) * from_camera_m;
  Eigen::Matrix3d wander = along_ray_m * along_ray_m.transpose();
  wander.diagonal().array() += kSidewaysWander * kSidewaysWander * along_ray_m.squaredNorm();
  // What is predicted goes on as it went: that shows no new mover either.
  const bool seen =
      status_ == BodyStatus::kTracked || (status_ == BodyStatus::kStereoOnly && sighted_features_ >= kTellingFeatures);
  if (!seen && !has_moved_) {
    wander.diagonal().array() += kAnywhere_m * kAnywhere_m;
  } else if (status_ == BodyStatus::kStereoOnly) {
    const double surface_m = 0.5 * surface_wander_m(depth_m);
    wander.diagonal().array() += surface_m * surface_m;
  }
  return wander;
}

void ObjectState::push_motion() {
  motion_.push({timestamp_ns_, T_world_obj_, reference_covariance(T_world_obj_, covariance_), position_wander()});
  previous_timestamp_ns_ = timestamp_ns_;
  const trajectory::MotionEstimate motion = motion_.at(0);
  has_moved_ = has_moved_ || motion.moving;
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
  if (track_.missed_frames == 0 && !half_hidden()) {
    width_m_ = track_.box_px.width() * p_cam.z() / geometry_.fx_px;
  }
  if ((track_.missed_frames == 0 && !mostly_covered()) || motion_.size() == 0) {
    last_seen_m_ = T_world_obj_ * -stereo_offset_m_;
  }
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
  result.box = box_.known() ? box_.box_in_world(result.T_world_obj) : Box3{.center_m = result.T_world_obj.translation};
  if (age > 0 && age >= motion_.size()) {
    return;  // The path has begun anew since: what was told of the motion before stands.
  }
  const trajectory::MotionEstimate motion = motion_.at(age);
  // Without a reconstruction, a velocity that is not significant is that of the seen surface, not of the object.
  const bool meaningful = result.status == BodyStatus::kTracked || motion.moving;
  result.velocity_mps = meaningful ? motion.velocity_mps : Eigen::Vector3d(Eigen::Vector3d::Zero());
  result.moving = motion.moving;
  result.heading_rad = motion.moving ? yaw_of(motion.velocity_mps) : result.box.yaw_rad;
}

}  // namespace kinetrace::pipeline
