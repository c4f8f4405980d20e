// Smaller eigenvalues of the gradient matrix, row by row with sliding sums.

#include "kernels.hpp"
#include "simd.hpp"

namespace kinetrace::features::KINETRACE_KERNEL_ISA {
namespace {

// Products of 16-bit numbers: the baseline has only these.
void accumulate_row(const Plane& image, int y, int sign, std::int32_t* __restrict xx, std::int32_t* __restrict xy,
                    std::int32_t* __restrict yy) {
  const std::uint8_t* __restrict row = image.data + static_cast<long>(y) * image.stride;
  const std::uint8_t* __restrict above = row - image.stride;
  const std::uint8_t* __restrict below = row + image.stride;
  const auto factor = static_cast<std::int16_t>(sign);
  for (int x = 0; x < image.width; ++x) {
    const auto gradient_x = static_cast<std::int16_t>(row[x + 1] - row[x - 1]);
    const auto gradient_y = static_cast<std::int16_t>(below[x] - above[x]);
    const auto signed_x = static_cast<std::int16_t>(factor * gradient_x);
    const auto signed_y = static_cast<std::int16_t>(factor * gradient_y);
    xx[x] += signed_x * gradient_x;
    xy[x] += signed_x * gradient_y;
    yy[x] += signed_y * gradient_y;
  }
}

inline Floats window_sum(const std::int32_t* sums) {
  Ints total;
  __builtin_memcpy(&total, sums - 2, sizeof(total));
  for (int offset = -1; offset <= 2; ++offset) {
    Ints next;
    __builtin_memcpy(&next, sums + offset, sizeof(next));
    total += next;
  }
  return __builtin_convertvector(total, Floats);
}

void eigenvalue_row(const std::int32_t* xx, const std::int32_t* xy, const std::int32_t* yy, int x0, int x1,
                    float* eigenvalues) {
  // 25 pixels; differences over two pixels are twice the gradient.
  // With a smaller ratio of eigenvalues it is an edge, along which the position is undefined.
  constexpr float kMinRatio = 0.1F;
  constexpr float kScale = 1.F / (25.F * 4.F);
  for (int x = x0; x < x1; x += kLanes) {
    const Floats a = window_sum(xx + x);
    const Floats b = window_sum(xy + x);
    const Floats c = window_sum(yy + x);
    const Floats half_difference = 0.5F * (a - c);
    const Floats half_sum = 0.5F * (a + c);
    const Floats half_spread = square_root(half_difference * half_difference + b * b);
    const Floats smaller = half_sum - half_spread;
    const Floats larger = half_sum + half_spread;
    store(eigenvalues + x, smaller > kMinRatio * larger ? smaller * kScale : Floats{});
  }
}

inline bool any(Ints mask) {
  std::uint64_t words[sizeof(mask) / sizeof(std::uint64_t)];
  __builtin_memcpy(words, &mask, sizeof(words));
  std::uint64_t all = 0;
  for (const std::uint64_t word : words) {
    all |= word;
  }
  return all != 0;
}

int find_maxima(const float* above, const float* row, const float* below, int x0, int x1, float threshold,
                std::uint16_t* columns) {
  int count = 0;
  for (int x = x0; x < x1; x += kLanes) {
    const Floats centre = load(row + x);
    Ints is_maximum = centre >= splat(threshold);
    if (!any(is_maximum)) {
      continue;
    }
    // The first of equal neighbours is the maximum.
    is_maximum &= (centre > load(above + x - 1)) & (centre > load(above + x)) & (centre > load(above + x + 1)) &
                  (centre > load(row + x - 1)) & (centre >= load(row + x + 1)) & (centre >= load(below + x - 1)) &
                  (centre >= load(below + x)) & (centre >= load(below + x + 1));
    if (!any(is_maximum)) {
      continue;
    }
    for (int i = 0; i < kLanes && x + i < x1; ++i) {
      if (is_maximum[i] != 0) {
        columns[count++] = static_cast<std::uint16_t>(x + i);
      }
    }
  }
  return count;
}

}  // namespace

extern const CornerKernels kCornerKernels;
const CornerKernels kCornerKernels = {&accumulate_row, &eigenvalue_row, &find_maxima};

}  // namespace kinetrace::features::KINETRACE_KERNEL_ISA
