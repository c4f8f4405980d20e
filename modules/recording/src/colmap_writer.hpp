// colmap/: each body's reconstruction as a COLMAP text model.
#pragma once

#include "spool.hpp"

namespace kinetrace::recording {

/// Reduces the spooled observations to those in frames whose finalised pose is the body's own ("images"). Expects
/// observations and poses in recorded order.
[[nodiscard]] Status keep_image_observations(const Workspace& workspace);

/// Expects final points, poses sorted by body and frame, and image observations. Writes cameras.txt, images.txt and
/// points3D.txt for the background and for each object that has a point seen in two images.
[[nodiscard]] Status write_colmap_models(const Workspace& workspace, RunCounts& counts);

}  // namespace kinetrace::recording
