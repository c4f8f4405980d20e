// Boxes and velocities in every frame, from an object's refined path.
#pragma once

#include "object_refinement.hpp"

namespace kinetrace::batch {

/// The box of all tracked frames is the most central one of the run, carried along the path; other frames keep their
/// own if it is more certain.
void place_boxes(const recording::Run& run, const ObjectHistory& history, RefinedObject& object);

/// Velocity of the box's centre, from the frames before and after; zero for stationary rows without their own
/// reconstruction, as in every run.
void set_velocities(RefinedObject& object);

}  // namespace kinetrace::batch
