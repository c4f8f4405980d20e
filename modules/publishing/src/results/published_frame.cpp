#include "kinetrace/publishing/published_frame.hpp"

#include <algorithm>

#include "results/thinning.hpp"

namespace kinetrace::publishing {
namespace {

/// Pose of a body's frame in the world; null: unknown.
const Se3* placement(const BodyGeometry& body, const FrameEstimate& newest, const Se3& world) noexcept {
  if (body.track_id == 0) {
    return &world;
  }
  const auto object = std::find_if(newest.objects.begin(), newest.objects.end(),
                                   [&](const ObjectResult& o) { return o.track_id == body.track_id; });
  return object == newest.objects.end() ? nullptr : &object->T_world_obj;
}

}  // namespace

PublishedFrame::PublishedFrame(const PublishConfig& config, Arena& arena)
    : objects(arena, static_cast<std::size_t>(config.max_objects)),
      points(arena, static_cast<std::size_t>(config.max_points)) {}

void PublishedFrame::assign(const FrameResult& result, std::int64_t now_ns, std::int64_t exposure_ns) noexcept {
  const FrameEstimate& newest = result.newest;
  frame_index = newest.frame_index;
  timestamp_ns = newest.timestamp_ns;
  handed_over_ns = now_ns;
  exposed_ns = exposure_ns;
  camera = newest.camera;
  objects.clear();
  for (const ObjectResult& object : newest.objects.first(std::min(newest.objects.size(), objects.capacity()))) {
    static_cast<void>(objects.push_back(object));
  }
  points.clear();
  points_available = 0;
  const Se3 world;
  for (const BodyGeometry& body : result.bodies) {
    points_available += placement(body, newest, world) == nullptr ? 0 : body.points.size();
  }
  Thinning thinning(points.capacity(), points_available);
  for (const BodyGeometry& body : result.bodies) {
    const Se3* T_world_body = placement(body, newest, world);
    if (T_world_body == nullptr) {
      continue;
    }
    const Eigen::Matrix3f rotation = T_world_body->rotation.cast<float>();
    const Eigen::Vector3f translation = T_world_body->translation.cast<float>();
    for (const BodyPoint& point : body.points) {
      if (thinning.lets_through()) {
        static_cast<void>(
            points.push_back({rotation * point.position_m + translation, body.track_id, point.intensity}));
      }
    }
  }
}

}  // namespace kinetrace::publishing
