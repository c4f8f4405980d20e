// Pictures of the world as radiance at the sensor.
#pragma once

#include "camera/camera_rig.hpp"
#include "rendering/ray_world.hpp"
#include "rendering/truth_renderer.hpp"
#include "util/image.hpp"

namespace kinetrace::simulator {

/// Adds `weight` times the light of each pixel of a camera. A pixel is the mean over its samples: a surface's texture
/// is filtered to the pixel's footprint, outlines and shadows are sampled. `truth`, if given, receives the hits of the
/// rays through the pixels' centres, as of render_truth with the same lens.
void add_radiance(const RayWorld& world, const SampleRays& rays, const ViewPose& view, int threads, float weight,
                  Image<float>& radiance, TruthImages* truth = nullptr);

}  // namespace kinetrace::simulator
