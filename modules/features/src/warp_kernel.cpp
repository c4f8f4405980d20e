// Image as seen by a slightly rotated camera. Plain loops that the compiler vectorises.
#include "kernels.hpp"

// Offsets within an image fit an int by far.
// NOLINTBEGIN(bugprone-implicit-widening-of-multiplication-result)
namespace kinetrace::features::KINETRACE_KERNEL_ISA {
namespace {

using Byte = std::uint8_t;

constexpr int kWidth = kWarpBlock;

int floor_of(float x) {
  const int whole = static_cast<int>(x);
  return static_cast<float>(whole) > x ? whole - 1 : whole;
}

Byte rounded(float gray) {
  const float floored = gray < 0.F ? 0.F : gray;
  const float limited = floored > 255.F ? 255.F : floored;
  constexpr float kHalf = 0.5F;  // Of a number that is not negative; unlike lround, this becomes vector instructions.
  return static_cast<Byte>(limited + kHalf);
}

/// Positions of a block's pixels: (u + k * du, v + k * dv).
struct Line {
  float u, v, du, dv;
};

/// A block spans neighbouring columns and two rows but for a small part of a pixel, so its pixels are read
/// contiguously; the remainder is extrapolated.
void block_inside(const Byte* __restrict upper, const Byte* __restrict lower, const Line& from, Byte* __restrict out) {
  for (int k = 0; k < kWidth; ++k) {
    const float fx = from.u + static_cast<float>(k) * from.du;
    const float fy = from.v + static_cast<float>(k) * from.dv;
    const float a = static_cast<float>(upper[k]);
    const float c = static_cast<float>(lower[k]);
    const float top = a + fx * (static_cast<float>(upper[k + 1]) - a);
    const float bottom = c + fx * (static_cast<float>(lower[k + 1]) - c);
    out[k] = rounded(top + fy * (bottom - top));
  }
}

int clamped(int value, int most) {
  const int floored = value < 0 ? 0 : value;
  return floored > most ? most : floored;
}

Byte pixel_at_border(const Plane& image, float u, float v) {
  const int x = floor_of(u);
  const int y = floor_of(v);
  const float fx = u - static_cast<float>(x);
  const float fy = v - static_cast<float>(y);
  const auto gray = [&](int column, int row) {
    return static_cast<float>(
        image.data[clamped(row, image.height - 1) * image.stride + clamped(column, image.width - 1)]);
  };
  const float top = gray(x, y) + fx * (gray(x + 1, y) - gray(x, y));
  const float bottom = gray(x, y + 1) + fx * (gray(x + 1, y + 1) - gray(x, y + 1));
  return rounded(top + fy * (bottom - top));
}

void warp_row(const Plane& image, const WarpNode* nodes, int width, Byte* target) {
  for (int x = 0, i = 0; x < width; x += kWidth, ++i) {
    const WarpNode& from = nodes[i];
    const WarpNode& to = nodes[i + 1];
    const Line line{from.u, from.v, (to.u - from.u) / kWidth, (to.v - from.v) / kWidth};
    const int x0 = floor_of(0.5F * (from.u + to.u - kWidth));
    const int y0 = floor_of(0.5F * (from.v + to.v));
    const int count = width - x < kWidth ? width - x : kWidth;
    if (count == kWidth && x0 >= 0 && x0 + kWidth < image.width && y0 >= 0 && y0 + 1 < image.height) {
      const Byte* upper = image.data + y0 * image.stride + x0;
      const Line fraction{line.u - static_cast<float>(x0), line.v - static_cast<float>(y0), line.du - 1.F, line.dv};
      block_inside(upper, upper + image.stride, fraction, target + x);
      continue;
    }
    for (int k = 0; k < count; ++k) {
      target[x + k] =
          pixel_at_border(image, line.u + static_cast<float>(k) * line.du, line.v + static_cast<float>(k) * line.dv);
    }
  }
}

}  // namespace

extern const WarpKernels kWarpKernels;
const WarpKernels kWarpKernels = {&warp_row};

}  // namespace kinetrace::features::KINETRACE_KERNEL_ISA
// NOLINTEND(bugprone-implicit-widening-of-multiplication-result)
