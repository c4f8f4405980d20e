// An object's points and path over all of its life.
#pragma once

#include <cstddef>
#include <map>
#include <span>
#include <vector>

#include "body_adjustment.hpp"
#include "object_history.hpp"

namespace kinetrace::batch {

/// One frame of a refined object.
struct RefinedObjectFrame {
  recording::ObjectRow row;
  Se3 T_obj_cam;
};

struct RefinedObject {
  std::map<std::size_t, RefinedObjectFrame> frames;  ///< By row of Run::camera.
  std::vector<RefinedPoint> points;                  ///< Object frame; `last_frame` is a row of Run::camera.
};

/// Adjusts the object's points with all of its poses under the motion that things usually have, wherever it was
/// followed without a gap. `T_world_cam` is the camera's refined path. What was not
/// refined moves with the camera.
/// Errors: those of the solver.
[[nodiscard]] Result<RefinedObject> refine_object(const recording::Run& run, std::span<const Se3> T_world_cam,
                                                  const ObjectHistory& history, const AdjustmentOptions& options);

}  // namespace kinetrace::batch
