// What follows from an object's refined path: its box and its velocity in every frame.
#pragma once

#include "object_refinement.hpp"

namespace kinetrace::batch {

/// Each frame's box is the one that is known best there: that of its own row, or that of the row that knows it best,
/// carried along the path.
void place_boxes(const ObjectHistory& history, RefinedObject& object);

/// Of the box's centre, from the frames before and after; rows without their own reconstruction that do not move have
/// none, as in every run.
void set_velocities(RefinedObject& object);

}  // namespace kinetrace::batch
