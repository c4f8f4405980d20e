// Whole-image passes: half-size images and horizontal gradients. Plain loops that the compiler vectorises.
#include "kernels.hpp"

// Offsets within an image fit an int by far.
// NOLINTBEGIN(bugprone-implicit-widening-of-multiplication-result)
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

/// 128 + Sobel x / 4, saturated, of the middle one of three rows.
void sobel_row(const Byte* __restrict above, const Byte* __restrict row, const Byte* __restrict below, int count,
               Byte* __restrict out) {
  for (int x = 0; x < count; ++x) {
    const int sobel = (above[x + 2] - above[x]) + 2 * (row[x + 2] - row[x]) + (below[x + 2] - below[x]);
    const int value = (sobel >> 2) + 128;
    const int floored = value < 0 ? 0 : value;
    out[x] = static_cast<Byte>(floored > 255 ? 255 : floored);
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
    const Byte* row = source.data + y * source.stride - 1;
    sobel_row(row - source.stride, row, row + source.stride, source.width, target + y * stride);
  }
}

}  // namespace

extern const PyramidKernels kPyramidKernels;
const PyramidKernels kPyramidKernels = {&downsample, &horizontal_gradient};

}  // namespace kinetrace::features::KINETRACE_KERNEL_ISA
// NOLINTEND(bugprone-implicit-widening-of-multiplication-result)
