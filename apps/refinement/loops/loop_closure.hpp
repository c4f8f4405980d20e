// Places that the camera saw twice.
#pragma once

#include <functional>
#include <span>
#include <vector>

#include "place_matcher.hpp"

namespace kinetrace::batch {

/// The loops of a path. Pictures are only read where poses say that a place may have been seen twice. `progress` gets
/// the part that is done. Errors: those of reading pictures.
[[nodiscard]] Result<std::vector<Loop>> find_loops(const recording::Run& run, std::span<const Se3> T_world_cam,
                                                   std::span<const Keyframe> keyframes, const PairReader& read,
                                                   const AdjustmentOptions& options,
                                                   const std::function<void(double)>& progress);

}  // namespace kinetrace::batch
