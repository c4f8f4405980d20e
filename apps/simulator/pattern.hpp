// Regular patterns with exact box filters: how much of a pixel's width a stripe covers.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>

#include "random.hpp"

namespace kinetrace::simulator {

/// std::floor of values that fit 32 bits, several times as quick where the instruction set has no rounding.
[[nodiscard]] inline float floor_of(float x) noexcept {
  const auto truncated = static_cast<float>(static_cast<std::int32_t>(x));
  return truncated > x ? truncated - 1.F : truncated;
}

/// Part of [x - width / 2, x + width / 2] that lies in [from, to].
[[nodiscard]] inline float band(float x, float from, float to, float width) noexcept {
  const float overlap = std::min(to, x + 0.5F * width) - std::max(from, x - 0.5F * width);
  return std::clamp(overlap / width, 0.F, 1.F);
}

/// The same for stripes [k period, k period + thickness] for all integers k.
[[nodiscard]] inline float stripes(float x, float period, float thickness, float width) noexcept {
  const auto covered_up_to = [&](float at) {
    const float cycles = floor_of(at / period);
    return cycles * thickness + std::min(at - cycles * period, thickness);
  };
  return std::clamp((covered_up_to(x + 0.5F * width) - covered_up_to(x - 0.5F * width)) / width, 0.F, 1.F);
}

/// Coverage of a disc of `radius` about the origin, seen at distance `r` from it.
[[nodiscard]] inline float disc(float r, float radius, float width) noexcept {
  return std::clamp((radius - r) / width + 0.5F, 0.F, 1.F);
}

/// Cubic step from 0 at `from` to 1 at `to`.
[[nodiscard]] inline float soft_step(float from, float to, float x) noexcept {
  const float t = std::clamp((x - from) / (to - from), 0.F, 1.F);
  return t * t * (3.F - 2.F * t);
}

[[nodiscard]] inline float mix(float a, float b, float t) noexcept {
  return a + (b - a) * t;
}

/// 1 for cells that a pixel resolves, fading to 0 for those it swallows.
[[nodiscard]] inline float resolved(float cell_m, float footprint_m) noexcept {
  return std::clamp(1.5F - 1.5F * footprint_m / cell_m, 0.F, 1.F);
}

/// In [0, 1), constant over one cell of a grid.
[[nodiscard]] inline float cell_value(float column, float row, std::uint32_t seed) noexcept {
  return unit_float(hash_of(seed, static_cast<std::int32_t>(column), static_cast<std::int32_t>(row)));
}

}  // namespace kinetrace::simulator
