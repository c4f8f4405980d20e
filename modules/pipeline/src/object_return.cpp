// The part of ObjectState that re-identifies lost objects among new tracks.
#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include "kinetrace/tracking/track_instance.hpp"
#include "object_state.hpp"

namespace kinetrace::pipeline {
namespace {

/// Density of new objects: one per frame in the well observed volume, 50 m x 50 m x 2 m.
constexpr double kNewObjectsPer_m3 = 1.0 / 5000.0;
// Standard deviation of a direction, from the nearest pixel of a mask, and its growth by the camera's motion.
constexpr double kDirectionSigma_px = 2.0;
constexpr double kDirectionDrift_pxps = 2.5;

/// From a point to the nearest pixel of a box.
double gap_px(const Eigen::Vector2d& point_px, const PixelBox& box) {
  const Eigen::Vector2d low(box.x0, box.y0);
  const Eigen::Vector2d high(box.x1 - 1, box.y1 - 1);
  return (point_px - point_px.cwiseMax(low).cwiseMin(high)).norm();
}

}  // namespace

bool ObjectState::is_reid_candidate(const Track& redetected) const noexcept {
  return alive() && life_.confirmed && tracking::classes_agree(life_.track.class_id, redetected.class_id) &&
         life_.track.missed_frames > redetected.age_frames;
}

std::optional<double> ObjectState::position_evidence(const StereoObservation& observation, const Track& redetected,
                                                     const CameraState& camera) const {
  if (!has_position() || !is_reid_candidate(redetected)) {
    return std::nullopt;
  }
  const Eigen::Vector3d p_cam = position_in_camera(geometry_, observation);
  const objects::StereoPosition measured{observation.uvd_px, observation.features, visible_part_of(camera.T_world_cam)};
  // Volume of a cubic pixel of (u_left, v, disparity) at this depth.
  const double m3_per_px3 =
      std::pow(p_cam.z(), 4) / (geometry_.fx_px * geometry_.fy_px * geometry_.fx_px * geometry_.baseline_m);
  const std::optional<double> log_likelihood = identity_.filter.log_likelihood(measured, camera.T_world_cam);
  return log_likelihood ? std::optional<double>(*log_likelihood - std::log(kNewObjectsPer_m3 * m3_per_px3))
                        : std::nullopt;
}

std::optional<double> ObjectState::bearing_evidence(const Track& redetected, const CameraState& camera) const {
  const tracking::ObjectPrediction expected = predict_direction(camera.T_world_cam);
  if (has_position() || !is_reid_candidate(redetected) || !expected.known || expected.depth_m <= 0.0) {
    return std::nullopt;
  }
  const double unseen_s = 1e-9 * static_cast<double>(life_.timestamp_ns - life_.matched_timestamp_ns);
  const double sigma_px = kDirectionSigma_px + kDirectionDrift_pxps * unseen_s;
  const double sigmas = gap_px(expected.point_px, redetected.box_px) / sigma_px;
  const double image_px2 = static_cast<double>(geometry_.width_px) * geometry_.height_px;
  return std::log(image_px2 / (2.0 * std::numbers::pi * sigma_px * sigma_px)) - 0.5 * sigmas * sigmas;
}

void ObjectState::continue_from(ObjectState& earlier) {
  life_.track.id = earlier.life_.track.id;
  life_.confirmed = earlier.life_.confirmed;
  if (!earlier.has_position()) {
    return;  // Only its identity is known.
  }
  life_.status = earlier.life_.status;
  identity_ = earlier.identity_;
  motion_ = earlier.motion_;
  identity_.drift_covariance = earlier.drift_covariance();
  std::swap(box_, earlier.box_);
}

}  // namespace kinetrace::pipeline
