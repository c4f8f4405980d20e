// Frames in which nothing is known of an object that was followed before or afterwards.
#pragma once

#include "object_refinement.hpp"

namespace kinetrace::batch {

/// Fills a gap by the smooth path between its ends, as `propagated` rows, where something that moves as things usually
/// do can have gone that way; elsewhere rows stay lost.
void fill_gaps(const recording::Run& run, std::span<const Se3> T_world_cam, RefinedObject& object);

/// Adds `propagated` rows before the first one, back to where the object's mask was seen first, as far as it seen from
/// there lies within the mask: by the velocity it had at first. `masks_px`: its masks, by row of Run::camera.
void fill_birth(const recording::Run& run, std::span<const Se3> T_world_cam,
                const std::map<std::size_t, PixelBox>& masks_px, RefinedObject& object);

}  // namespace kinetrace::batch
