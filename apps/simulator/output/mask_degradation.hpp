// Instance masks as a network would deliver them.
#pragma once

#include <cstdint>

#include "util/image.hpp"

namespace kinetrace::simulator {

struct DegradationSettings {
  double border_px = 1.5;           ///< Largest displacement of borders.
  double miss_probability = 0.05;   ///< Of each object in each picture.
  double false_probability = 0.04;  ///< Of a false positive in a picture.
  int smallest_px = 60;             ///< Smaller masks are always missed.
};

/// Degrades exact KITTI MOTS labels as a network would: noisy borders, misses, occasional false positives, and ids that
/// are valid in this picture only. `stream` identifies the randomness: seed, frame and camera.
[[nodiscard]] Image<std::uint16_t> degraded_masks(const Image<std::uint16_t>& labels,
                                                  const DegradationSettings& settings, std::uint32_t stream);

/// Exact masks with ids that are valid in this picture only.
[[nodiscard]] Image<std::uint16_t> shuffled_masks(const Image<std::uint16_t>& labels, std::uint32_t stream);

}  // namespace kinetrace::simulator
