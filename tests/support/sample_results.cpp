#include "sample_results.hpp"

namespace kinetrace::test {

Se3 SampleResult::T_world_cam(std::int64_t frame) {
  const double t_s = static_cast<double>(frame * kPeriod_ns) * 1e-9;
  return {so3_exp({0.0, kTurn_radps * t_s, 0.0}), {0.1, -0.2, kSpeed_mps * t_s}};
}

ObjectResult SampleResult::object(std::uint32_t track_id, std::int64_t frame) {
  const double id = track_id;
  const double t_s = static_cast<double>(frame * kPeriod_ns) * 1e-9;
  ObjectResult object;
  object.track_id = track_id;
  object.class_id = static_cast<std::uint16_t>(1 + track_id % 2);
  object.label = static_cast<std::uint8_t>(track_id % 64 + 1);
  object.status = BodyStatus::kTracked;
  object.moving = track_id % 2 == 1;
  object.velocity_mps = object.moving ? Eigen::Vector3d(0.5, 0.0, 2.0) : Eigen::Vector3d(0.0, 0.0, 0.0);
  object.T_world_obj = {so3_exp({0.0, 0.1 * id, 0.0}), Eigen::Vector3d(id, 1.0, 10.0 + id) + object.velocity_mps * t_s};
  object.T_obj_cam = object.T_world_obj.inverse() * T_world_cam(frame);
  object.covariance = 0.01 * id * Matrix6d::Identity();
  object.covariance(0, 4) = object.covariance(4, 0) = 0.001;
  object.heading_rad = -1.3;
  object.box = {object.T_world_obj.translation, {4.0, 1.5, 1.8}, -1.3};
  object.box_sigma = {{0.5, 0.1, 0.2}, {0.6, 0.15, 0.25}, 0.05, true};
  object.box_px = {10, 20, 110, 70};
  object.point_count = 40;
  object.inliers = 30;
  return object;
}

Eigen::Vector3f SampleResult::point(std::uint32_t track_id, std::size_t i) {
  return {0.1F * static_cast<float>(i), -0.01F * static_cast<float>(i), 1.0F + static_cast<float>(track_id)};
}

StereoGeometry SampleResult::geometry() {
  return {.fx_px = 721.5,
          .fy_px = 720.5,
          .cx_px = 609.5,
          .cy_px = 172.8,
          .baseline_m = 0.54,
          .width_px = 1242,
          .height_px = 375};
}

SampleResult::SampleResult(const SampleContent& content, std::int64_t frame) {
  for (int i = 0; i < content.objects; ++i) {
    objects.push_back(object(static_cast<std::uint32_t>(i) + 1, frame));
  }
  points_.resize(objects.size() + 1);
  for (std::size_t body = 0; body < points_.size(); ++body) {
    const auto track_id = static_cast<std::uint32_t>(body);
    const auto count = static_cast<std::size_t>(body == 0 ? content.background_points : content.points_per_object);
    for (std::size_t i = 0; i < count; ++i) {
      points_[body].push_back({.id = static_cast<std::uint32_t>(1000 * body + i),
                               .position_m = point(track_id, i),
                               .observations = 3,
                               .intensity = static_cast<std::uint8_t>(i % 256)});
    }
    bodies.push_back({track_id, BodyStatus::kTracked, false, points_[body], {}, {}});
  }
  result.newest = {frame,
                   timestamp_ns(frame),
                   {BodyStatus::kTracked, T_world_cam(frame), 1e-4 * Matrix6d::Identity(), 200},
                   objects};
  result.has_finalised = true;
  result.finalised = result.newest;
  result.bodies = bodies;
  result.counters.frames = static_cast<std::uint64_t>(frame) + 1;
}

}  // namespace kinetrace::test
