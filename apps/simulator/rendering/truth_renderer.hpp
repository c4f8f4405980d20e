// Exact content of each pixel, by the ray through its centre.
#pragma once

#include <cstdint>

#include "kinetrace/core/se3.hpp"
#include "kinetrace/core/stereo_geometry.hpp"
#include "rendering/ray_world.hpp"
#include "util/image.hpp"

namespace kinetrace::simulator {

struct TruthImages {
  /// Only sky.
  TruthImages(int width_px, int height_px) : actors(width_px, height_px), depth_m(width_px, height_px) {}

  Image<std::uint16_t> actors;  ///< Index into Scene::actors plus one; 0 without an actor.
  Image<float> depth_m;         ///< Along the optical axis; 0 for the sky.
};

/// Truth of the rectified image of a camera at `T_scene_view`.
[[nodiscard]] TruthImages render_truth(const RayWorld& world, const StereoGeometry& geometry, const Se3& T_scene_view,
                                       int threads);

/// Number of pixels of the rectified image that an actor would cover without occlusion.
[[nodiscard]] int unoccluded_pixels(const RayWorld& world, const StereoGeometry& geometry, const Se3& T_scene_view,
                                    int actor, const PixelBox& search_px);

}  // namespace kinetrace::simulator
