// Where the path comes back to what it has left: keyframes that may show the same place, by their poses alone.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "keyframes.hpp"

namespace kinetrace::batch {

/// By which a path may have drifted from one keyframe to a later one: 2 % of its length, two sigmas of what stereo
/// odometry has on real drives (Geiger et al. 2012), and two sigmas of its steps where little is seen.
[[nodiscard]] double largest_drift_m(const Keyframe& from, const Keyframe& to);

/// By keyframe: those before it that look at much the same from much the same place, after the camera had left it:
/// within 0.3 of their depth (what is seen grows by less than 1.4) and 13 degrees, give or take the drift between the
/// two. Time grows with the square of the keyframes, some nanoseconds each.
[[nodiscard]] std::vector<std::vector<std::size_t>> find_revisits(std::span<const Keyframe> keyframes,
                                                                  std::span<const Se3> T_world_cam);

}  // namespace kinetrace::batch
