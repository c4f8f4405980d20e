#include "scene.hpp"

#include <Eigen/Geometry>

#include "kinetrace/core/detections.hpp"

namespace kinetrace::test {
namespace {

CameraResult camera_at(std::int64_t frame) {
  CameraResult camera;
  camera.status = BodyStatus::kTracked;
  camera.T_world_cam.rotation = Eigen::Quaterniond(0.8, 0.0, 0.6, 0.0).toRotationMatrix();
  camera.T_world_cam.translation = {1.0, 2.0, 3.0 + 0.01 * static_cast<double>(frame)};
  camera.covariance.diagonal() << 1.0, 2.0, 3.0, 4.0, 5.0, 6.0;
  camera.covariance(0, 4) = camera.covariance(4, 0) = 0.5;
  return camera;
}

ObjectResult car(std::uint32_t id) {
  ObjectResult object;
  object.track_id = id;
  object.class_id = kVehicleClass;
  object.status = BodyStatus::kTracked;
  object.moving = true;
  object.T_world_obj.translation = {5.0, 1.0, 10.0};
  object.covariance = 0.25 * Matrix6d::Identity();
  object.velocity_mps = {0.0, 0.0, 2.0};
  object.box.center_m = {5.0, 0.5, 10.0};
  object.box.size_m = {4.5, 1.5, 1.75};  // Length, height, width.
  object.box_sigma = {.center_m = {0.1, 0.2, 0.3}, .size_m = {0.1, 0.1, 0.1}, .yaw_rad = 0.2, .heading_known = true};
  object.point_count = 1;
  return object;
}

ObjectResult lost_pedestrian(std::uint32_t id) {
  ObjectResult object;
  object.track_id = id;
  object.class_id = kPedestrianClass;
  object.status = BodyStatus::kLost;
  return object;
}

}  // namespace

Scene::Scene(const Options& options) : options_(options) {
  background_points_[0].position_m = {1.0F, 2.0F, 3.0F};
  background_points_[1].position_m = {-4.0F, -5.0F, 60.0F};
  object_point_.position_m = {0.5F, 0.25F, -1.0F};
  place_objects();
}

void Scene::place_objects() {
  objects_.clear();
  for (std::size_t i = 0; i < options_.objects; ++i) {
    objects_.push_back(car(next_id_++));
  }
  objects_.push_back(lost_pedestrian(next_id_++));
  bodies_.clear();
  bodies_.push_back(
      {.track_id = 0, .status = BodyStatus::kTracked, .points = background_points_, .observations = {}, .retired = {}});
  for (const ObjectResult& object : objects_) {
    if (object.status == BodyStatus::kTracked) {
      bodies_.push_back({.track_id = object.track_id,
                         .status = object.status,
                         .points = {&object_point_, 1},
                         .observations = {},
                         .retired = {}});
    }
  }
}

const FrameResult& Scene::next() {
  finalised_objects_.assign(objects_.begin(), objects_.end() - 1);
  if (options_.has_new_ids && frame_ > 0) {
    place_objects();
  }
  result_ = {};
  result_.newest = {frame_, kBegin_ns + frame_ * kStep_ns, camera_at(frame_), objects_};
  result_.has_finalised = frame_ > 0;
  result_.finalised = {frame_ - 1, kBegin_ns + (frame_ - 1) * kStep_ns, camera_at(frame_ - 1), finalised_objects_};
  result_.bodies = bodies_;
  result_.counters.frames = static_cast<std::uint64_t>(++frame_);
  return result_;
}

publishing::PublishedHealth Scene::health() const {
  publishing::PublishedHealth health;
  health.frame_index = frame_ - 1;
  health.handed_over_ns = kBegin_ns;
  health.state = HealthState::kDegraded;
  health.camera = "streaming";
  for (std::size_t i = 0; i < health.entries.size(); ++i) {
    health.entries[i].reason = static_cast<HealthReason>(i);
  }
  health.entries[static_cast<std::size_t>(HealthReason::kFramesLost)].count = 7;
  health.counters = result_.counters;
  return health;
}

StereoGeometry Scene::geometry() {
  return {.fx_px = 700.0,
          .fy_px = 700.0,
          .cx_px = 620.0,
          .cy_px = 190.0,
          .baseline_m = 0.5,
          .width_px = 1240,
          .height_px = 376};
}

}  // namespace kinetrace::test
