// The part of ObjectState that gives the box estimator the evidence of a frame.
#include <array>
#include <cmath>
#include <limits>

#include "object_state.hpp"

namespace kinetrace::pipeline {
namespace {

constexpr double kPointDisparitySigma_px = 0.1;  // Of a reconstructed point, correlated with its neighbours'.
constexpr double kSlipAngleSigma_rad = 0.035;    // Slip angle of vehicles.
/// Of the length, from the centre to the rear axle, which moves along the heading.
constexpr double kRearAxleOffset = 0.28;
constexpr double kTurnRateSigma_radps = 0.1;  // Of the turn rate, standard deviation.

}  // namespace

std::optional<trajectory::Heading> ObjectState::heading(const Eigen::Vector3d& down) const {
  const trajectory::MotionEstimate motion = motion_.at(0);
  if (!motion.moving_by_path) {
    return std::nullopt;
  }
  // In a turn, only the rear axle moves along the vehicle's heading.
  Eigen::Vector3d arm_m = Eigen::Vector3d::Zero();
  if (box_.known()) {
    const Box3 box = box_.box_in_object();
    arm_m = box.center_m - kRearAxleOffset * box.size_m.x() * box.rotation().col(0) - identity_.reference_m;
  }
  const Eigen::Vector3d velocity_mps = velocity_at(motion, identity_.T_world_obj.rotation * arm_m);
  const double speed_mps = velocity_mps.norm();
  const Eigen::Vector3d across = down.cross(velocity_mps).normalized();
  const double sigma_mps =
      std::hypot(std::sqrt(across.dot(motion.covariance * across)), kTurnRateSigma_radps * arm_m.norm());
  return trajectory::Heading{upright_yaw(down, velocity_mps), std::hypot(kSlipAngleSigma_rad, sigma_mps / speed_mps)};
}

std::optional<trajectory::MaskEdges> ObjectState::mask_edges() const {
  if (life_.track.missed_frames > 0 || life_.track.area_px == 0) {
    return std::nullopt;
  }
  const PixelBox& box = life_.track.box_px;
  const std::array<bool, 4> at_border{box.x0 <= 1, box.x1 >= geometry_.width_px - 1, box.y0 <= 1,
                                      box.y1 >= geometry_.height_px - 1};
  const bool is_at_border = at_border[0] || at_border[1] || at_border[2] || at_border[3];
  const double occluded_fraction =
      1.0 - double{std::min(is_at_border ? 1.F : life_.track.visible_part, frame_.visible_fraction)};
  trajectory::MaskEdges edges{{box.x0 - 0.5, box.x1 - 0.5, box.y0 - 0.5, box.y1 - 0.5}, {}};
  for (std::size_t side = 0; side < at_border.size(); ++side) {
    const int extent_px = side < 2 ? box.width() : box.height();
    edges.beyond_sigma_px[side] =
        at_border[side] ? std::numeric_limits<double>::infinity() : occluded_fraction * extent_px;
  }
  return edges;
}

void ObjectState::update_box(const CameraState& camera, const trajectory::Ground& ground) {
  if (!camera.valid) {
    return;
  }
  if (frame_.change == FrameChange::kReplaced) {
    box_.forget_views();
  }
  trajectory::BoxFrame frame{.timestamp_ns = life_.timestamp_ns,
                             .class_id = life_.track.class_id,
                             .T_world_obj = identity_.T_world_obj,
                             .T_obj_cam = life_.T_obj_cam,
                             .edges = mask_edges(),
                             .points = body_.active() ? body_.estimate().points : std::span<const BodyPoint>(),
                             .disparity_sigma_px = kPointDisparitySigma_px,
                             .ground = ground,
                             .is_rotation_measured = life_.status == BodyStatus::kTracked,
                             .heading = heading(ground.down)};
  const BodyPoint visible_center{.position_m = (-identity_.to_origin_m).cast<float>()};
  if (frame.points.empty()) {
    frame.points = {&visible_center, 1};
    frame.disparity_sigma_px = kObservedDisparitySigma_px;
  }
  box_.update(frame);
  update_reference_point();
}

void ObjectState::update_reference_point() {
  const std::span<const BodyPoint> points = body_.estimate().points;
  if (!body_.active() || points.empty()) {
    return;
  }
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (const BodyPoint& point : points) {
    sum += point.position_m.cast<double>();
  }
  identity_.reference_m = sum / static_cast<double>(points.size());
  motion_.set_reference(identity_.reference_m);
}

Box3Sigma ObjectState::box_sigma(const ObjectResult& result) const {
  Box3Sigma sigma = box_.sigma();
  const Eigen::Matrix3d axes = result.box.rotation();
  const Eigen::Matrix3d pose_covariance =
      axes.transpose() * reference_covariance(result.T_world_obj, result.covariance) * axes;
  sigma.center_m = (sigma.center_m.cwiseAbs2() + pose_covariance.diagonal()).cwiseSqrt();
  if (result.status == BodyStatus::kTracked) {  // Otherwise its frame does not turn with it: see heading().
    const double turn_rad2 = axes.col(1).dot(result.covariance.topLeftCorner<3, 3>() * axes.col(1));
    sigma.yaw_rad = std::sqrt(sigma.yaw_rad * sigma.yaw_rad + turn_rad2);
  }
  return sigma;
}

}  // namespace kinetrace::pipeline
