// Ground truth of the objects in a frame.
#pragma once

#include <cstdint>
#include <vector>

#include "rendering/stereo_simulator.hpp"
#include "rendering/truth_renderer.hpp"

namespace kinetrace::simulator {

/// All objects of the scene, visible or not. `truth` is that of the left camera.
[[nodiscard]] std::vector<ObjectTruth> observe_objects(const RayWorld& world, const StereoGeometry& geometry,
                                                       const TruthImages& truth, double time_s, const Se3& T_scene_cam,
                                                       const Se3& T_world_scene);

/// KITTI MOTS values from actor numbers.
[[nodiscard]] Image<std::uint16_t> mots_labels(const Image<std::uint16_t>& actors, const std::vector<Actor>& scene);

}  // namespace kinetrace::simulator
