// Search for places that the camera saw twice.
#pragma once

#include <functional>
#include <span>
#include <vector>

#include "place_matcher.hpp"

namespace kinetrace::batch {

/// The loops of a path. Pictures are read only where the poses allow the same place. `progress` gets the fraction done.
/// Errors: those of reading pictures.
[[nodiscard]] Result<std::vector<Loop>> find_loops(const recording::Run& run, std::span<const Se3> T_world_cam,
                                                   std::span<const Keyframe> keyframes, const PairReader& read,
                                                   const AdjustmentOptions& options,
                                                   const std::function<void(double)>& progress);

}  // namespace kinetrace::batch
