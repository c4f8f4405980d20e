// Solid fractal noise: the natural structure on every surface.
#pragma once

#include <array>
#include <cstdint>

#include <Eigen/Core>

namespace kinetrace::simulator {

/// Eight octaves of value noise (K. Perlin, "An image synthesizer", SIGGRAPH 1985), each half as large as the one
/// before.
struct Octaves {
  static constexpr int kCount = 8;
  alignas(32) std::array<float, kCount> frequency{};  ///< Lattice cells per metre.
  alignas(32) std::array<float, kCount> amplitude{};
  std::uint32_t seed = 0;

  /// The first `count` octaves, from cells of `largest_cell_m` down, each `gain` times as strong as the one before. The
  /// sum has unit variance.
  Octaves(float largest_cell_m, float gain, int count, std::uint32_t seed);
};

/// Zero mean, about unit variance. Octaves fade out as their cells become smaller than `footprint_m`, the size of a
/// pixel on the surface: what a pixel cannot resolve must not flicker in it.
[[nodiscard]] float fractal_noise(const Octaves& octaves, const Eigen::Vector3f& point, float footprint_m);

}  // namespace kinetrace::simulator
