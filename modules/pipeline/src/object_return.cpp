// The part of ObjectState that tells whether a new track is an object that was lost.
#include <algorithm>
#include <cmath>
#include <utility>

#include "object_state.hpp"

namespace kinetrace::pipeline {
namespace {

// How far from where it is expected a lost object may be found again: that it stood still or went on is half the truth.
// Where it should be in plain sight, a detection has only been missed, and what appears beside it is something else.
constexpr std::int64_t kMissedInView_ns = 300'000'000;
constexpr std::int64_t kMissedHidden_ns = 0;
constexpr double kReachOfWay = 0.5;
constexpr double kMaxReach_m = 3.0;
constexpr double kReachAtRest_m = 0.8;
constexpr double kTieBreak = 0.01;
// What has only a direction is found within so much of it, and more as the camera goes on.
constexpr double kDirectionReach_px = 8.0;
constexpr double kDirectionDrift_pxps = 10.0;
// What comes in over the border of the image shows itself to stereo within this time.
constexpr std::int64_t kMaxUnnamed_ns = 600'000'000;

/// From a point to the nearest pixel of a box.
double gap_px(const Eigen::Vector2d& point_px, const PixelBox& box) {
  const Eigen::Vector2d low(box.x0, box.y0);
  const Eigen::Vector2d high(box.x1 - 1, box.y1 - 1);
  return (point_px - point_px.cwiseMax(low).cwiseMin(high)).norm();
}

}  // namespace

std::optional<Eigen::Vector3d> ObjectState::observed_position(const FeatureFrame& frame, LabelView labels,
                                                              const CameraState& camera) const {
  const StereoObservation observation = observe_stereo(frame, labels);
  if (observation.features < config_.stereo_only_min_features || !camera.valid) {
    return std::nullopt;
  }
  return camera.T_world_cam * position_in_camera(geometry_, observation);
}

Eigen::Vector3d ObjectState::off_body(const Eigen::Vector3d& observed_m, const Eigen::Vector3d& about_m) const {
  Eigen::Vector3d off_m = observed_m - about_m;
  if (!box_.known()) {
    return off_m;
  }
  const Eigen::Matrix3d& R_world_obj = identity_.T_world_obj.rotation;
  const Eigen::Vector3d outside_m =
      R_world_obj * offset_from(box_.box_in_object(), R_world_obj.transpose() * off_m - identity_.to_origin_m);
  return outside_m.norm() < off_m.norm() ? outside_m : off_m;
}

bool ObjectState::is_reid_candidate(const Track& redetected, std::int64_t missed_ns) const noexcept {
  return alive() && life_.confirmed && life_.track.class_id == redetected.class_id &&
         life_.track.missed_ns > missed_ns && life_.track.missed_frames > redetected.age_frames;
}

double ObjectState::depth_sigma_m(double depth_m) const {
  return kObservedDisparitySigma_px * depth_m * depth_m / (geometry_.fx_px * geometry_.baseline_m);
}

std::optional<double> ObjectState::position_gate(const Eigen::Vector3d& position_m, const Track& redetected,
                                                 const CameraState& camera) const {
  const bool hidden = !life_.in_view || mostly_occluded();
  if (!life_.placed || !is_reid_candidate(redetected, hidden ? kMissedHidden_ns : kMissedInView_ns)) {
    return std::nullopt;
  }
  const Eigen::Vector3d expected_m = middle_m();
  // It may have stopped as well as gone on.
  const Eigen::Vector3d way_m = expected_m - life_.last_seen_m;
  const double gone = way_m.squaredNorm() > 0.0
                          ? std::clamp((position_m - life_.last_seen_m).dot(way_m) / way_m.squaredNorm(), 0.0, 1.0)
                          : 0.0;
  const Eigen::Vector3d nearest_m = life_.last_seen_m + gone * way_m;
  const double speed_mps = identity_.filter.velocity_mps().norm();
  const double unseen_s = 1e-9 * static_cast<double>(life_.timestamp_ns - life_.matched_timestamp_ns);
  const double depth_m = (camera.T_world_cam.inverse() * position_m).z();
  // Of what is half hidden when it goes and when it comes, the middle may lie anywhere on it.
  const double reach_m =
      std::min(std::max(kReachAtRest_m, identity_.width_m) + kReachOfWay * speed_mps * unseen_s, kMaxReach_m);
  // Depth is as uncertain as its square.
  const Eigen::Vector3d off_m = camera.T_world_cam.rotation.transpose() * off_body(position_m, nearest_m);
  const double part =
      std::hypot(off_m.head<2>().norm() / reach_m, off_m.z() / (reach_m + 2.0 * depth_sigma_m(depth_m)));
  if (part > 1.0) {
    return std::nullopt;
  }
  // Of two whose boxes hold it, the one nearer to its middle.
  return std::min(1.0, part + kTieBreak * (position_m - nearest_m).norm() / reach_m);
}

std::optional<double> ObjectState::bearing_gate(const Track& redetected, const CameraState& camera) const {
  const tracking::ObjectPrediction expected = predict_direction(camera.T_world_cam);
  if (life_.placed || !is_reid_candidate(redetected, kMissedInView_ns) || !expected.known || expected.depth_m <= 0.0) {
    return std::nullopt;
  }
  const double unseen_s = 1e-9 * static_cast<double>(life_.timestamp_ns - life_.matched_timestamp_ns);
  const double part =
      gap_px(expected.point_px, redetected.box_px) / (kDirectionReach_px + kDirectionDrift_pxps * unseen_s);
  return part <= 1.0 ? std::optional<double>(part) : std::nullopt;
}

bool ObjectState::may_come_back_as(const Track& redetected, const CameraState& camera) const {
  const PixelBox& box = redetected.box_px;
  const bool at_border = box.x0 <= 0 || box.y0 <= 0 || box.x1 >= geometry_.width_px || box.y1 >= geometry_.height_px;
  if (!life_.placed || !at_border || redetected.age_ns > kMaxUnnamed_ns ||
      !is_reid_candidate(redetected, kMissedHidden_ns)) {
    return false;
  }
  const Eigen::Vector3d p_cam = camera.T_world_cam.inverse() * (middle_m());
  if (p_cam.z() <= 0.0) {
    return false;
  }
  const Eigen::Vector2d expected_px = geometry_.project(p_cam).head<2>();
  const bool outside = expected_px.x() < 0.0 || expected_px.x() >= geometry_.width_px || expected_px.y() < 0.0 ||
                       expected_px.y() >= geometry_.height_px;
  return outside && gap_px(expected_px, box) <= identity_.width_m * geometry_.fx_px / p_cam.z();
}

void ObjectState::continue_from(ObjectState& earlier) {
  life_.track.id = earlier.life_.track.id;
  life_.confirmed = earlier.life_.confirmed;
  if (!earlier.life_.placed) {
    return;  // Nothing but its name is known.
  }
  life_.placed = true;
  identity_ = earlier.identity_;
  identity_.drift_covariance = earlier.drift_covariance();
  recogniser_.swap(earlier.recogniser_);
  std::swap(box_, earlier.box_);
}

}  // namespace kinetrace::pipeline
