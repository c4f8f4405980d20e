// Boxes and velocities in every frame, from an object's refined path.
#pragma once

#include "object_refinement.hpp"

namespace kinetrace::batch {

/// Each frame's box is the most certain one: its own, or that of the row with the smallest variance, carried along the
/// path.
void place_boxes(const ObjectHistory& history, RefinedObject& object);

/// Velocity of the box's centre, from the frames before and after; zero for stationary rows without their own
/// reconstruction, as in every run.
void set_velocities(RefinedObject& object);

}  // namespace kinetrace::batch
