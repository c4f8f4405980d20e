// An object's points and path over its whole life.
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

/// Adjusts the object's points jointly with all of its poses under the usual motion of objects, in each stretch tracked
/// without a gap. `T_world_cam` is the camera's refined path. Rows that are not refined move with the camera. Errors:
/// those of the solver.
[[nodiscard]] Result<RefinedObject> refine_object(const recording::Run& run, std::span<const Se3> T_world_cam,
                                                  const ObjectHistory& history, const AdjustmentOptions& options);

}  // namespace kinetrace::batch
