// Sampling of 16 x 11 patches, a vector of pixels at a time, for kernel sources only.
#pragma once

#include "kernels.hpp"
#include "simd.hpp"

// Offsets within an image fit an int by far.
// NOLINTBEGIN(bugprone-implicit-widening-of-multiplication-result)
namespace kinetrace::features::KINETRACE_KERNEL_ISA {

static inline int floor_to_int(float v) {
  const int truncated = static_cast<int>(v);
  return truncated - static_cast<int>(v < static_cast<float>(truncated));
}

template <int kCount>
static inline void interpolate_row(const std::uint8_t* row, Floats fraction, Floats* out) {
  for (int i = 0; i < kCount; ++i) {
    const Floats left = load_bytes(row + kLanes * i);
    const Floats right = load_bytes(row + kLanes * i + 1);
    out[i] = left + fraction * (right - left);
  }
}

/// Bilinear samples with the first at (x, y): calls use(row, values) for each of `kRows` rows of kCount vectors.
template <int kCount, int kRows, typename Use>
static inline void sample_rows(const Plane& plane, float x, float y, Use&& use) {
  const int column = floor_to_int(x);
  const int line = floor_to_int(y);
  const Floats fraction_x = splat(x - static_cast<float>(column));
  const Floats fraction_y = splat(y - static_cast<float>(line));
  const std::uint8_t* row = plane.data + static_cast<long>(line) * plane.stride + column;
  Floats upper[kCount];
  interpolate_row<kCount>(row, fraction_x, upper);
  for (int i = 0; i < kRows; ++i) {
    row += plane.stride;
    Floats lower[kCount];
    interpolate_row<kCount>(row, fraction_x, lower);
    Floats values[kCount];
    for (int k = 0; k < kCount; ++k) {
      values[k] = upper[k] + fraction_y * (lower[k] - upper[k]);
      upper[k] = lower[k];
    }
    use(i, values);
  }
}

/// Sets samples that do not count to zero.
template <bool kMasked>
static inline Floats masked(Floats value, const PatchTemplate& patch, int index) {
  return kMasked ? value * load(patch.weight + index) : value;
}

/// The gradient before orthogonalisation to the patch and a constant. `raw` belongs to `gradient`.
template <bool kMasked>
static inline Floats raw_gradient(const PatchTemplate& patch, const float* gradient, const float (&raw)[2], int index) {
  return load(gradient + index) + raw[0] * load(patch.value + index) + masked<kMasked>(splat(raw[1]), patch, index);
}

}  // namespace kinetrace::features::KINETRACE_KERNEL_ISA
// NOLINTEND(bugprone-implicit-widening-of-multiplication-result)
