// Cars driving ahead of a moving camera, and tracks without error, which a test may modify.
#pragma once

#include <functional>
#include <numbers>
#include <vector>

#include "kinetrace/evaluation/object_metrics.hpp"

namespace kinetrace::evaluation {

inline constexpr int kSceneFrames = 20;
inline constexpr double kFrameInterval_s = 0.1;
inline constexpr double kCarSpeed_mps = 10.0;

/// Object 1 turns gently while driving; object 2 is at rest; both 10 to 15 m from the camera.
inline Se3 true_pose(std::uint32_t id, int frame) {
  if (id == 2) {
    return {so3_exp({0.0, 0.4, 0.0}), {-4.0, 1.0, 10.0}};
  }
  const double turned_rad = 0.02 * frame;
  const double radius_m = kCarSpeed_mps * kFrameInterval_s / 0.02;
  // Heading along -z rotated by `turned`: x forward of the object, a circle about a point to the right.
  return {so3_exp({0.0, turned_rad, 0.0}),
          {radius_m * std::sin(turned_rad) - 8.0, 1.5, 12.0 + radius_m * (std::cos(turned_rad) - 1.0)}};
}

inline TrueObject true_object(std::uint32_t id, int frame) {
  TrueObject object;
  object.id = id;
  object.class_id = 1;
  object.moving = id == 1;
  object.height_px = 80;
  object.T_world_obj = true_pose(id, frame);
  object.center_m = object.T_world_obj * Eigen::Vector3d(0.0, -0.75, 0.0);
  object.size_m = {4.2, 1.5, 1.8};
  if (object.moving) {
    object.velocity_mps = kCarSpeed_mps * object.T_world_obj.rotation.col(0);
  }
  return object;
}

inline TrackInFrame perfect_track(const TrueObject& object, std::uint32_t track_id) {
  TrackEstimate estimate;
  estimate.status = BodyStatus::kTracked;
  estimate.T_world_obj = object.T_world_obj;
  estimate.box = {object.center_m, object.size_m,
                  std::atan2(-object.T_world_obj.rotation(2, 0), object.T_world_obj.rotation(0, 0))};
  estimate.velocity_mps = object.velocity_mps;
  estimate.moving = object.moving;
  estimate.heading_rad = std::atan2(-object.velocity_mps.z(), object.velocity_mps.x());
  return {track_id, estimate};
}

/// Track 11 is object 1, track 12 object 2.
inline std::vector<ObjectFrame> perfect_scene(int frames = kSceneFrames) {
  std::vector<ObjectFrame> scene;
  for (int i = 0; i < frames; ++i) {
    ObjectFrame frame;
    frame.frame = i;
    for (const std::uint32_t id : {1U, 2U}) {
      frame.truth.push_back(true_object(id, i));
      frame.tracks.push_back(perfect_track(frame.truth.back(), 10 + id));
    }
    frame.similarity = Eigen::Matrix2d{{0.9, 0.0}, {0.0, 0.9}};
    scene.push_back(frame);
  }
  return scene;
}

/// Changes object 1's estimate in every frame.
inline std::vector<ObjectFrame> spoiled_scene(const std::function<void(TrackEstimate&, int frame)>& spoil) {
  std::vector<ObjectFrame> scene = perfect_scene();
  for (ObjectFrame& frame : scene) {
    spoil(*frame.tracks[0].estimate, static_cast<int>(frame.frame));
  }
  return scene;
}

}  // namespace kinetrace::evaluation
