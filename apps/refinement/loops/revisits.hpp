// Returns of the path to earlier places: keyframes that may show the same place, by their poses alone.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "keyframes.hpp"

namespace kinetrace::batch {

/// Largest drift of a path from one keyframe to a later one: 2 % of its length, two sigmas of stereo odometry on real
/// drives (Geiger et al. 2012), and two sigmas of its steps in frames with few points.
[[nodiscard]] double largest_drift_m(const Keyframe& from, const Keyframe& to);

/// By keyframe: earlier keyframes with a similar view from a similar place, which the camera had left in between:
/// within 0.3 of their depth (objects' image size grows by less than 1.4) and 13 degrees, plus the drift between the
/// two. Time grows with the square of the number of keyframes, some nanoseconds per pair.
[[nodiscard]] std::vector<std::vector<std::size_t>> find_revisits(std::span<const Keyframe> keyframes,
                                                                  std::span<const Se3> T_world_cam);

}  // namespace kinetrace::batch
