#include "rendering/object_truth.hpp"

#include <algorithm>
#include <cmath>

namespace kinetrace::simulator {
namespace {

constexpr double kNearest_m = 0.2;
constexpr double kStanding_mps = 0.05;

struct Projection {
  bool in_front = false;
  double left = 1e9;
  double top = 1e9;
  double right = -1e9;
  double bottom = -1e9;

  void include(const Eigen::Vector3d& uv) {
    left = std::min(left, uv.x());
    right = std::max(right, uv.x());
    top = std::min(top, uv.y());
    bottom = std::max(bottom, uv.y());
  }
};

// Outline of the box; edges are clipped at a plane just in front of the camera.
Projection project_box(const StereoGeometry& geometry, const Se3& T_cam_obj, const Eigen::Vector3d& size_lhw_m) {
  std::array<Eigen::Vector3d, 8> corners;
  for (std::size_t i = 0; i < corners.size(); ++i) {
    corners[i] = T_cam_obj * Eigen::Vector3d((i & 1U) != 0U ? 0.5 * size_lhw_m.x() : -0.5 * size_lhw_m.x(),
                                             (i & 2U) != 0U ? -size_lhw_m.y() : 0.0,
                                             (i & 4U) != 0U ? 0.5 * size_lhw_m.z() : -0.5 * size_lhw_m.z());
  }
  Projection projection;
  for (std::size_t i = 0; i < corners.size(); ++i) {
    if (corners[i].z() >= kNearest_m) {
      projection.in_front = true;
      projection.include(geometry.project(corners[i]));
    }
    for (const std::size_t bit : {1U, 2U, 4U}) {
      const Eigen::Vector3d& a = corners[i];
      const Eigen::Vector3d& b = corners[i ^ bit];
      if (a.z() >= kNearest_m && b.z() < kNearest_m) {
        projection.include(geometry.project(a + (kNearest_m - a.z()) / (b.z() - a.z()) * (b - a)));
      }
    }
  }
  return projection;
}

Eigen::Vector3d velocity_at(const Actor& actor, double time_s) {
  constexpr double kStep_s = 1e-3;
  return (actor.T_scene_obj(time_s + kStep_s).translation - actor.T_scene_obj(time_s - kStep_s).translation) /
         (2.0 * kStep_s);
}

struct Footprint {
  int pixels = 0;
  PixelBox box_px;
};

std::vector<Footprint> footprints(const Image<std::uint16_t>& actors, std::size_t count) {
  std::vector<Footprint> result(count);
  for (int y = 0; y < actors.height(); ++y) {
    for (int x = 0; x < actors.width(); ++x) {
      if (const std::uint16_t actor = actors.at(x, y); actor != 0) {
        Footprint& footprint = result[actor - 1U];
        ++footprint.pixels;
        footprint.box_px.include(x, y);
      }
    }
  }
  return result;
}

void set_visibility(const RayWorld& world, const StereoGeometry& geometry, const Se3& T_scene_cam,
                    const Projection& projection, const Footprint& footprint, ObjectTruth& object) {
  const double right_end = geometry.width_px - 1.0;
  const double bottom_end = geometry.height_px - 1.0;
  object.projected_px = {std::clamp(projection.left, 0.0, right_end), std::clamp(projection.top, 0.0, bottom_end),
                         std::clamp(projection.right, 0.0, right_end), std::clamp(projection.bottom, 0.0, bottom_end)};
  const auto& [left, top, right, bottom] = object.projected_px;
  const double whole = (projection.right - projection.left) * (projection.bottom - projection.top);
  object.truncation = whole > 0.0 ? 1.0 - (right - left) * (bottom - top) / whole : 1.0;
  object.visible_px = footprint.pixels;
  object.box_px = footprint.box_px;
  // Parts such as mirrors and swinging arms may stick out of the box.
  constexpr int kMargin_px = 8;
  const PixelBox search{std::max(static_cast<int>(left) - kMargin_px, 0),
                        std::max(static_cast<int>(top) - kMargin_px, 0),
                        std::min(static_cast<int>(right) + kMargin_px, geometry.width_px),
                        std::min(static_cast<int>(bottom) + kMargin_px, geometry.height_px)};
  const int whole_px = unoccluded_pixels(world, geometry, T_scene_cam, object.id - 1, search);
  object.occlusion = whole_px > 0 ? std::clamp(1.0 - static_cast<double>(footprint.pixels) / whole_px, 0.0, 1.0) : 0.0;
}

}  // namespace

std::vector<ObjectTruth> observe_objects(const RayWorld& world, const StereoGeometry& geometry,
                                         const TruthImages& truth, double time_s, const Se3& T_scene_cam,
                                         const Se3& T_world_scene) {
  const std::vector<Actor>& actors = world.scene().actors;
  const std::vector<Footprint> seen = footprints(truth.actors, actors.size());
  std::vector<ObjectTruth> objects;
  for (std::size_t i = 0; i < actors.size(); ++i) {
    const Actor& actor = actors[i];
    const Se3 T_scene_obj = actor.T_scene_obj(time_s);
    const Projection projection = project_box(geometry, T_scene_cam.inverse() * T_scene_obj, actor.size_lhw_m);
    ObjectTruth& object = objects.emplace_back();
    object.id = static_cast<int>(i) + 1;
    object.class_id = actor.class_id;
    object.rigid = actor.rigid;
    object.size_lhw_m = actor.size_lhw_m;
    object.T_world_obj = T_world_scene * T_scene_obj;
    object.velocity_mps = T_world_scene.rotation * velocity_at(actor, time_s);
    object.moving = object.velocity_mps.norm() > kStanding_mps;
    if (projection.in_front) {
      set_visibility(world, geometry, T_scene_cam, projection, seen[i], object);
    }
  }
  return objects;
}

Image<std::uint16_t> mots_labels(const Image<std::uint16_t>& actors, const std::vector<Actor>& scene) {
  Image<std::uint16_t> labels(actors.width(), actors.height());
  std::transform(actors.pixels().begin(), actors.pixels().end(), labels.pixels().begin(), [&](std::uint16_t actor) {
    return static_cast<std::uint16_t>(actor == 0 ? 0 : scene[actor - 1U].class_id * 1000 + actor);
  });
  return labels;
}

}  // namespace kinetrace::simulator
