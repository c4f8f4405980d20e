#include "study/pixel_noise.hpp"

#include <cmath>

#include "kinetrace/core/quantiles.hpp"

namespace kinetrace::app {
namespace {

constexpr std::int64_t kMotsIdsPerClass = 1000;

}  // namespace

void PixelNoiseMeter::add(const FrameResult& result, const Se3& T_world_cam,
                          const std::vector<evaluation::LocatedObject>& objects, const TrueImages& images) {
  for (const evaluation::LocatedObject& object : objects) {
    const Se3 T_cam_obj = T_world_cam.inverse() * object.object.T_world_obj;
    for (const evaluation::MaskInstance& instance : images.masks.instances) {
      if (instance.id % kMotsIdsPerClass != object.object.id) {
        continue;
      }
      for (const BodyGeometry& body : result.bodies) {
        for (const PointObservation& observation : body.observations) {
          const auto depth_m = images.depth_at(double{observation.u_left_px}, double{observation.v_px}, instance.label);
          if (body.track_id != 0 && depth_m) {
            add_observation(observation, *depth_m, T_cam_obj, {result.newest.frame_index, object.object.id, {}});
          }
        }
      }
    }
  }
}

void PixelNoiseMeter::add_observation(const PointObservation& observation, double depth_m, const Se3& T_cam_obj,
                                      Seen seen) {
  const Eigen::Vector2d at_px(double{observation.u_left_px}, double{observation.v_px});
  const double disparity_px = geometry_.disparity_px(depth_m);
  if (std::isfinite(observation.u_right_px)) {
    disparity_px_.push_back(std::abs(at_px.x() - double{observation.u_right_px} - disparity_px));
  }
  seen.position_m = T_cam_obj.inverse() * geometry_.triangulate(at_px.x(), at_px.y(), disparity_px);
  const auto [last, is_new] = last_.try_emplace(observation.point_id, seen);
  if (!is_new && last->second.frame + 1 == seen.frame && last->second.object_id == seen.object_id) {
    const Eigen::Vector2d expected_px = geometry_.project(T_cam_obj * last->second.position_m).head<2>();
    for (const double error_px : at_px - expected_px) {
      position_px_.push_back(std::abs(error_px));
    }
  }
  last->second = seen;
}

std::optional<PixelNoise> PixelNoiseMeter::noise() const {
  if (position_px_.empty() || disparity_px_.empty()) {
    return std::nullopt;
  }
  constexpr double kSigmasOfMedian = 1.4826;
  return PixelNoise{kSigmasOfMedian * median(std::vector(position_px_)) / std::sqrt(2.0),
                    kSigmasOfMedian * median(std::vector(disparity_px_))};
}

}  // namespace kinetrace::app
