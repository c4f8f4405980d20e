#include "scenes/clearance.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

namespace kinetrace::simulator {
namespace {

using Eigen::Vector2d;

// A rectangle on the ground: centre and half axes.
struct Place {
  Vector2d centre = Vector2d::Zero();
  Vector2d along = Vector2d::Zero();
  Vector2d across = Vector2d::Zero();
  double top_m = 0.0;
};

Vector2d on_ground(const Eigen::Vector3d& v) {
  return {v.x(), v.z()};
}

Place place_of(const Actor& actor, double time_s) {
  constexpr double kApart_m = 0.1;  // On each side.
  const Se3 pose = actor.T_scene_obj(time_s);
  return {on_ground(pose.translation), (0.5 * actor.size_lhw_m.x() + kApart_m) * on_ground(pose.rotation.col(0)),
          (0.5 * actor.size_lhw_m.z() + kApart_m) * on_ground(pose.rotation.col(2)),
          actor.size_lhw_m.y() - pose.translation.y()};
}

// Two convex shapes are apart if an axis across a side of one of them separates them.
bool overlap(const Place& a, const Place& b) {
  const auto apart_along = [&](const Vector2d& axis) {
    const double reach = std::abs(axis.dot(a.along)) + std::abs(axis.dot(a.across)) + std::abs(axis.dot(b.along)) +
                         std::abs(axis.dot(b.across));
    return std::abs(axis.dot(b.centre - a.centre)) > reach;
  };
  const std::array<Vector2d, 4> axes{a.along, a.across, b.along, b.across};
  return std::none_of(axes.begin(), axes.end(), apart_along);
}

bool collides_at(const Scene& scene, double time_s) {
  constexpr double kCameraReach_m = 0.7;
  constexpr double kFlyOver_m = 1.0;
  const Eigen::Vector3d view = scene.T_scene_cam(time_s).translation;
  const Place camera{on_ground(view), {kCameraReach_m, 0.0}, {0.0, kCameraReach_m}, -view.y()};
  std::vector<Place> places;
  for (const Actor& actor : scene.actors) {
    const Place place = place_of(actor, time_s);
    const auto meets = [&](const Place& other) { return overlap(place, other); };
    if (std::any_of(places.begin(), places.end(), meets) ||
        (camera.top_m < place.top_m + kFlyOver_m && overlap(place, camera))) {
      return true;
    }
    places.push_back(place);
  }
  return false;
}

}  // namespace

bool has_collision(const Scene& scene) {
  for (int frame = 0; frame < scene.frames; ++frame) {
    if (collides_at(scene, frame / scene.rate_hz)) {
      return true;
    }
  }
  return false;
}

}  // namespace kinetrace::simulator
