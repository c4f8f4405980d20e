// Whole-image passes: half-size images and horizontal gradients. Plain loops that the compiler vectorises.
#include "kernels.hpp"

namespace kinetrace::features::KINETRACE_KERNEL_ISA {
namespace {

using Byte = std::uint8_t;
using Word = std::uint16_t;

/// Column sums of four rows with weights 1 3 3 1.
void sum_rows(const Byte* __restrict a, const Byte* __restrict b, const Byte* __restrict c, const Byte* __restrict d,
              int count, Word* __restrict out) {
  for (int x = 0; x < count; ++x) {
    out[x] = static_cast<Word>(a[x] + d[x] + 3 * (b[x] + c[x]));
  }
}

/// Every second weighted sum, 1 3 3 1, of a row of column sums.
void sum_columns(const Word* __restrict sums, int count, Byte* __restrict out) {
  for (int x = 0; x < count; ++x) {
    const Word outer = static_cast<Word>(sums[2 * x] + sums[2 * x + 3]);
    const Word inner = static_cast<Word>(sums[2 * x + 1] + sums[2 * x + 2]);
    out[x] = static_cast<Byte>(static_cast<Word>(outer + static_cast<Word>(3 * inner) + 32) >> 6);
  }
}

void downsample(const Plane& source, std::uint8_t* target, int width, int height, int stride, std::uint16_t* scratch) {
  for (int y = 0; y < height; ++y) {
    const Byte* row = source.data + 2 * y * source.stride - 1;
    sum_rows(row - source.stride, row, row + source.stride, row + 2 * source.stride, 2 * width + 2, scratch);
    sum_columns(scratch, width, target + y * stride);
  }
}

void horizontal_gradient(const Plane& source, std::uint8_t* target, int stride) {
  for (int y = 0; y < source.height; ++y) {
    const Byte* __restrict row = source.data + y * source.stride;
    const Byte* __restrict above = row - source.stride;
    const Byte* __restrict below = row + source.stride;
    Byte* __restrict out = target + y * stride;
    for (int x = 0; x < source.width; ++x) {
      const std::int16_t sobel = static_cast<std::int16_t>(
          (above[x + 1] - above[x - 1]) + 2 * (row[x + 1] - row[x - 1]) + (below[x + 1] - below[x - 1]));
      std::int16_t value = static_cast<std::int16_t>((sobel >> 2) + 128);
      value = value < 0 ? static_cast<std::int16_t>(0) : value;
      out[x] = static_cast<Byte>(value > 255 ? 255 : value);
    }
  }
}

}  // namespace

extern const PyramidKernels kPyramidKernels;
const PyramidKernels kPyramidKernels = {&downsample, &horizontal_gradient};

}  // namespace kinetrace::features::KINETRACE_KERNEL_ISA
