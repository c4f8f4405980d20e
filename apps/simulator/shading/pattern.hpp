// Regular patterns with exact box filters: the coverage of a pixel's width by stripes. For kernel sources.
#pragma once

#include <cstdint>

#include "util/lanes.hpp"
#include "util/random.hpp"

namespace kinetrace::simulator::KINETRACE_KERNEL_ISA {

/// Fraction of [x - width / 2, x + width / 2] that lies in [from, to].
[[nodiscard]] inline Floats band(Floats x, Floats from, Floats to, Floats width) noexcept {
  const Floats overlap = min(to, x + 0.5F * width) - max(from, x - 0.5F * width);
  return clamp(overlap / width, 0.F, 1.F);
}

/// The same for stripes [k period, k period + thickness] for all integers k.
[[nodiscard]] inline Floats stripes(Floats x, float period, float thickness, Floats width) noexcept {
  const auto covered_up_to = [&](Floats at) {
    const Floats cycles = floor_of(at / period);
    return cycles * thickness + min(at - cycles * period, thickness);
  };
  return clamp((covered_up_to(x + 0.5F * width) - covered_up_to(x - 0.5F * width)) / width, 0.F, 1.F);
}

/// Coverage of a disc of `radius` about the origin, seen at distance `r` from it.
[[nodiscard]] inline Floats disc(Floats r, float radius, Floats width) noexcept {
  return clamp((radius - r) / width + 0.5F, 0.F, 1.F);
}

/// Cubic step from 0 at `from` to 1 at `to`.
[[nodiscard]] inline Floats soft_step(Floats from, Floats to, Floats x) noexcept {
  const Floats t = clamp((x - from) / (to - from), 0.F, 1.F);
  return t * t * (3.F - 2.F * t);
}

[[nodiscard]] inline Floats mix(Floats a, Floats b, Floats t) noexcept {
  return a + (b - a) * t;
}

/// 1 for cells that a pixel resolves, fading to 0 for those that it does not.
[[nodiscard]] inline Floats resolved(float cell_m, Floats footprint_m) noexcept {
  return clamp(1.5F - 1.5F * footprint_m / cell_m, 0.F, 1.F);
}

/// In [0, 1), constant over one cell of a grid, as unit_float(hash_of(seed, column, row)).
[[nodiscard]] inline Floats cell_value(Floats column, Floats row, std::uint32_t seed) noexcept {
  const WordVector in_column = hash_step(hash_of(seed) + WordVector{}, to_words(truncated(column)));
  const WordVector in_cell = hash_step(in_column, to_words(truncated(row)));
  return to_floats(to_ints(in_cell >> 8U)) * 0x1p-24F;
}

/// In [0, 1), constant over all surfaces of one paint; independent for each `property` of the paint.
[[nodiscard]] inline float paint_value(std::uint32_t seed, std::uint32_t property) noexcept {
  return unit_float(hash_of(seed, property));
}

}  // namespace kinetrace::simulator::KINETRACE_KERNEL_ISA
