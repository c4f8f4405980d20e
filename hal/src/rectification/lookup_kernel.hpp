// Remaps images by a look-up table: the hot loop of rectification, once per instruction set.
#pragma once

#include <cstddef>
#include <cstdint>

namespace kinetrace::hal {

/// Fractions are in 1/32 px, both ends included: 32 is the whole way to the next pixel.
inline constexpr int kLookupSteps = 32;

/// Source position of each pixel of a row: pixel and fraction.
struct LookupRow {
  const std::int16_t* positions;   ///< x, y; each with x + 1 and y + 1 within the source.
  const std::uint16_t* fractions;  ///< Of x in the lower byte, of y in the upper one.
  int width;
};

/// target[i] = the four pixels around entry i, bilinear, rounded.
using LookupKernel = void (*)(const std::uint8_t* source, std::ptrdiff_t stride, const LookupRow& row,
                              std::uint8_t* target);

/// The fastest kernel of this machine; see cpu_runs_fast_kernels.
[[nodiscard]] LookupKernel lookup_kernel() noexcept;
/// The portable kernel.
[[nodiscard]] LookupKernel baseline_lookup_kernel() noexcept;

}  // namespace kinetrace::hal
