// Frames in which nothing is known of an object that was followed before and afterwards.
#pragma once

#include "object_refinement.hpp"

namespace kinetrace::batch {

/// Fills a gap by the smooth path between its ends, as `propagated` rows, where something that moves as things usually
/// do can have gone that way; elsewhere rows stay lost.
void fill_gaps(const recording::Run& run, std::span<const Se3> T_world_cam, RefinedObject& object);

}  // namespace kinetrace::batch
