// points/: the reconstructed points as PLY.
#pragma once

#include "spool.hpp"

namespace kinetrace::recording {

/// Reduces the spooled points to the final ones: sorted by body and id, each id once (in its last position), seen in at
/// least two frames, and not stray. Expects poses sorted by body and frame.
[[nodiscard]] Status keep_final_points(const Workspace& workspace, RunCounts& counts);

/// Expects final points and poses sorted by body and frame. Writes background.ply and, for each object that has points,
/// object_ID_model.ply (object frame) and object_ID.ply (all its points at every frame, in the world).
[[nodiscard]] Status write_point_clouds(const Workspace& workspace, RunCounts& counts);

}  // namespace kinetrace::recording
