// Paths of a run folder on the map.
#pragma once

#include <vector>

#include "kinetrace/geo/alignment.hpp"
#include "kinetrace/geo/map_files.hpp"
#include "kinetrace/recording/run_reader.hpp"

namespace kinetrace::map {

/// The camera's path for the alignment.
[[nodiscard]] std::vector<geo::PathPose> camera_path(const recording::Run& run);

/// The camera and, by track id, every object with a position: the middle of its box. Frames in which it was lost are
/// left out.
[[nodiscard]] std::vector<geo::MapTrajectory> map_trajectories(const recording::Run& run,
                                                               const geo::Alignment& alignment);

}  // namespace kinetrace::map
