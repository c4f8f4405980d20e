// Instance masks as a network would deliver them.
#pragma once

#include <cstdint>

#include "util/image.hpp"

namespace kinetrace::simulator {

struct DegradationSettings {
  double border_px = 1.5;           ///< How far borders drift.
  double miss_probability = 0.05;   ///< Of each object in each picture.
  double false_probability = 0.04;  ///< Of an invented object in a picture.
  int smallest_px = 60;             ///< Smaller masks are never found.
};

/// What a network makes of exact KITTI MOTS labels: drifting borders, misses, now and then something that is not
/// there, and ids that mean nothing beyond this picture. `stream` names the randomness: seed, frame and camera.
[[nodiscard]] Image<std::uint16_t> degraded_masks(const Image<std::uint16_t>& labels,
                                                  const DegradationSettings& settings, std::uint32_t stream);

/// Exact masks, but with ids that mean nothing beyond this picture.
[[nodiscard]] Image<std::uint16_t> shuffled_masks(const Image<std::uint16_t>& labels, std::uint32_t stream);

}  // namespace kinetrace::simulator
