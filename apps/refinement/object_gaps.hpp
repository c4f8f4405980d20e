// Interpolation of frames in which an object was lost, and extrapolation before its track's start.
#pragma once

#include "object_refinement.hpp"

namespace kinetrace::batch {

/// Fills a gap by the smooth path between its ends, as `propagated` rows, where usual motion allows that path;
/// elsewhere rows stay lost.
void fill_gaps(const recording::Run& run, std::span<const Se3> T_world_cam, RefinedObject& object);

/// Adds `propagated` rows before the first one, back to the first of the object's masks, while the centre, extrapolated
/// with the first velocity, projects into the mask's box. `masks_px`: its masks, by row of Run::camera.
void fill_birth(const recording::Run& run, std::span<const Se3> T_world_cam,
                const std::map<std::size_t, PixelBox>& masks_px, RefinedObject& object);

}  // namespace kinetrace::batch
