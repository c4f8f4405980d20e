#include <algorithm>
#include <cstddef>
#include <cstring>

#include "dense_kernels.hpp"

// Offsets within an image fit an int by far.
// NOLINTBEGIN(bugprone-implicit-widening-of-multiplication-result)
namespace kinetrace::segmentation::KINETRACE_KERNEL_ISA {
namespace {

void decimate(GrayView source, int step, MutableGrayView target) {
  for (int y = 0; y < target.height; ++y) {
    std::uint8_t* const out = target.row(y);
    if (step == 1) {
      std::memcpy(out, source.row(y), static_cast<std::size_t>(target.width));
      continue;
    }
    const std::uint8_t* const above = source.row(2 * y);
    const std::uint8_t* const below = source.row(std::min(2 * y + 1, source.height - 1));
    const int whole = source.width / 2;
    for (int x = 0; x < whole; ++x) {
      out[x] = static_cast<std::uint8_t>((above[2 * x] + above[2 * x + 1] + below[2 * x] + below[2 * x + 1] + 2) >> 2);
    }
    for (int x = whole; x < target.width; ++x) {
      out[x] = static_cast<std::uint8_t>((above[2 * x] + below[2 * x] + 1) >> 1);
    }
  }
}

void horizontal_gradient(GrayView image, MutableGrayView target) {
  for (int y = 0; y < image.height; ++y) {
    const std::uint8_t* const in = image.row(y);
    std::uint8_t* const out = target.row(y);
    out[0] = 128;
    out[image.width - 1] = 128;
    for (int x = 1; x < image.width - 1; ++x) {
      const int slope = static_cast<int>(in[x + 1]) - static_cast<int>(in[x - 1]);
      out[x] = static_cast<std::uint8_t>(128 + std::clamp(slope, -63, 63));
    }
  }
}

#if defined(__AVX2__)
constexpr int kLanes = 16;
#else
constexpr int kLanes = 8;
#endif
using Bytes = std::uint8_t __attribute__((vector_size(kLanes)));
using Words = std::int16_t __attribute__((vector_size(2 * kLanes)));

template <typename Vector>
Vector load(const void* source) {
  Vector v;
  __builtin_memcpy(&v, source, sizeof(v));
  return v;
}

template <typename Vector>
void store(void* target, Vector v) {
  __builtin_memcpy(target, &v, sizeof(v));
}

Bytes difference(const std::uint8_t* a, const std::uint8_t* b) {
  const Bytes va = load<Bytes>(a);
  const Bytes vb = load<Bytes>(b);
  return va > vb ? va - vb : vb - va;
}

/// sum[x] = differences of all rows of the window; writes up to kLanes - 1 elements past `count`, and reads as far.
void add_rows(const std::uint8_t* const* left, const std::uint8_t* const* right, int shift, int count,
              std::int16_t* sum) {
  for (int x = 0; x < count; x += kLanes) {
    Words total{};
    for (int k = 0; k < kMatchHeight; k += 2) {
      // No gradient differs by more than 126 from another: two differences fit a byte.
      const Bytes two =
          difference(left[k] + shift + x, right[k] + x) + difference(left[k + 1] + shift + x, right[k + 1] + x);
      total += __builtin_convertvector(two, Words);
    }
    store(sum + x, total);
  }
}

/// sum[x] += sum[x + reach], from left to right: nothing is read after it was written.
void add_columns(int reach, int count, std::int16_t* sum) {
  for (int x = 0; x < count; x += kLanes) {
    store(sum + x, load<Words>(sum + x) + load<Words>(sum + x + reach));
  }
}

void match_row(GrayView left, GrayView right, int first_row, int pitch, int offset, int cells, int levels,
               std::int16_t* columns, std::int16_t* costs, int stride) {
  static_assert(kMatchHeight == 6 && kMatchWidth == 8);
  const int width = left.width;
  const std::uint8_t* const l[6] = {left.row(first_row),     left.row(first_row + 1), left.row(first_row + 2),
                                    left.row(first_row + 3), left.row(first_row + 4), left.row(first_row + 5)};
  const std::uint8_t* const r[6] = {right.row(first_row),     right.row(first_row + 1), right.row(first_row + 2),
                                    right.row(first_row + 3), right.row(first_row + 4), right.row(first_row + 5)};
  for (int d = 0; d < levels; ++d) {
    const int used = width - d;
    add_rows(l, r, d, used, columns);
    for (const int reach : {1, 2, 4}) {
      add_columns(reach, used, columns);
    }
    std::int16_t* const out = costs + static_cast<std::ptrdiff_t>(d) * stride;
    // Columns are counted from the first one that both images show.
    const int first = (std::max(0, d - offset) + pitch - 1) / pitch;
    const int end = std::min(cells, (width - kMatchWidth - offset) / pitch + 1);
    std::fill_n(out, std::min(first, cells), kNoCost);
    for (int i = first; i < end; ++i) {
      out[i] = columns[i * pitch + offset - d];
    }
    std::fill(out + std::min(std::max(first, end), cells), out + cells, kNoCost);
  }
}

void choose_levels(const std::int16_t* costs, int cells, int levels, int stride, std::int16_t* best, std::int16_t* cost,
                   std::int16_t* rival) {
  for (int i = 0; i < cells; i += kLanes) {
    Words least = Words{} + kNoCost;
    Words at{};
    for (int d = 0; d < levels; ++d) {
      const Words c = load<Words>(costs + static_cast<std::ptrdiff_t>(d) * stride + i);
      const Words level = Words{} + static_cast<std::int16_t>(d);
      at = c < least ? level : at;
      least = c < least ? c : least;
    }
    Words second = Words{} + kNoCost;
    for (int d = 0; d < levels; ++d) {
      const Words c = load<Words>(costs + static_cast<std::ptrdiff_t>(d) * stride + i);
      const Words apart = Words{} + static_cast<std::int16_t>(d) - at;
      second = ((apart > 1) | (apart < -1)) & (c < second) ? c : second;
    }
    store(best + i, at);
    store(cost + i, least);
    store(rival + i, second);
  }
}

float patch_difference(GrayView image, int x, int y, GrayView other, float shift_x, float shift_y) {
  const float ox = static_cast<float>(x) + shift_x;
  const float oy = static_cast<float>(y) + shift_y;
  if (!(ox >= 0.F && oy >= 0.F && ox + kPatchPx < static_cast<float>(other.width) &&
        oy + kPatchPx < static_cast<float>(other.height))) {
    return -1.F;
  }
  // In 1/32 of a pixel: all weights together are 1024.
  const int x0 = static_cast<int>(ox);
  const int y0 = static_cast<int>(oy);
  const int fx = static_cast<int>(32.F * (ox - static_cast<float>(x0)) + 0.5F);
  const int fy = static_cast<int>(32.F * (oy - static_cast<float>(y0)) + 0.5F);
  const int w00 = (32 - fx) * (32 - fy);
  const int w01 = fx * (32 - fy);
  const int w10 = (32 - fx) * fy;
  const int w11 = fx * fy;
  int total = 0;
  for (int j = 0; j < kPatchPx; ++j) {
    const std::uint8_t* const a = image.row(y + j) + x;
    const std::uint8_t* const b = other.row(y0 + j) + x0;
    const std::uint8_t* const c = other.row(y0 + j + 1) + x0;
    for (int i = 0; i < kPatchPx; ++i) {
      const int value = w00 * b[i] + w01 * b[i + 1] + w10 * c[i] + w11 * c[i + 1];
      const int difference = 1024 * a[i] - value;
      total += difference < 0 ? -difference : difference;
    }
  }
  return static_cast<float>(total) / (1024.F * static_cast<float>(kPatchPx * kPatchPx));
}

bool patch_sums(GrayView image, int x, int y, GrayView other, float shift_x, float shift_y, PatchSums& sums) {
  const float ox = static_cast<float>(x) + shift_x;
  const float oy = static_cast<float>(y) + shift_y;
  if (!(ox >= 0.F && oy >= 0.F && ox + kPatchPx < static_cast<float>(other.width) &&
        oy + kPatchPx < static_cast<float>(other.height))) {
    return false;
  }
  const int x0 = static_cast<int>(ox);
  const int y0 = static_cast<int>(oy);
  const float a = ox - static_cast<float>(x0);
  const float b = oy - static_cast<float>(y0);
  sums = {};
  for (int j = 0; j < kPatchPx; ++j) {
    const std::uint8_t* const now = image.row(y + j) + x;
    const std::uint8_t* const above = other.row(y0 + j) + x0;
    const std::uint8_t* const below = other.row(y0 + j + 1) + x0;
    for (int i = 0; i < kPatchPx; ++i) {
      const auto p00 = static_cast<float>(above[i]);
      const auto p01 = static_cast<float>(above[i + 1]);
      const auto p10 = static_cast<float>(below[i]);
      const auto p11 = static_cast<float>(below[i + 1]);
      const float top = p00 + a * (p01 - p00);
      const float bottom = p10 + a * (p11 - p10);
      const float gx = (1.F - b) * (p01 - p00) + b * (p11 - p10);
      const float gy = bottom - top;
      const float r = top + b * gy - static_cast<float>(now[i]);
      sums.xx += gx * gx;
      sums.xy += gx * gy;
      sums.yy += gy * gy;
      sums.xr += gx * r;
      sums.yr += gy * r;
      sums.rr += r * r;
    }
  }
  return true;
}

}  // namespace

extern const DenseKernels kDenseKernels;
const DenseKernels kDenseKernels{decimate, horizontal_gradient, match_row, choose_levels, patch_difference, patch_sums};

}  // namespace kinetrace::segmentation::KINETRACE_KERNEL_ISA
// NOLINTEND(bugprone-implicit-widening-of-multiplication-result)
