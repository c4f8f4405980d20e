// Solid fractal noise: the natural structure on every surface.
#pragma once

#include <cstdint>

#include "shading/surface_pack.hpp"

namespace kinetrace::simulator {

/// Up to eight octaves of value noise (K. Perlin, "An image synthesizer", SIGGRAPH 1985), each half as large as the one
/// before.
struct Octaves {
  static constexpr int kMax = 8;
  // Plain arrays: kernels must not call the standard library.
  float frequency[kMax]{};  ///< Lattice cells per metre.
  float amplitude[kMax]{};
  int count;  ///< How many there are.
  std::uint32_t seed;

  /// `count` octaves, from cells of `largest_cell_m` down, each `gain` times as strong as the one before. The sum has
  /// unit variance.
  Octaves(float largest_cell_m, float gain, int count, std::uint32_t seed);
};

/// At eight points: zero mean, about unit variance. Octaves fade out as their cells become smaller than `footprint_m`,
/// the size of a pixel on the surface: unresolved detail would flicker.
[[nodiscard]] Lanes fractal_noise(const Octaves& octaves, const Lanes3& points, const Lanes& footprint_m);

}  // namespace kinetrace::simulator
