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
using Bytes = std::uint8_t __attribute__((vector_size(2 * kLanes)));
using BytePairs = std::uint16_t __attribute__((vector_size(2 * kLanes)));
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
  return (va > vb ? va : vb) - (va > vb ? vb : va);
}

/// sums[k] = differences of two rows in columns 2k and 2k + 1.
void add_column_pairs(const std::uint8_t* const* left, const std::uint8_t* const* right, int count,
                      std::int16_t* sums) {
  for (int k = 0; k < count; k += kLanes) {
    // Gradients differ by at most 126: two differences fit a byte.
    const Bytes two = difference(left[0] + 2 * k, right[0] + 2 * k) + difference(left[1] + 2 * k, right[1] + 2 * k);
    const auto pairs = reinterpret_cast<BytePairs>(two);
    store(sums + k, reinterpret_cast<Words>((pairs & 0xFF) + (pairs >> 8)));
  }
}

/// target[k] = sums[k] + sums[k + reach], from left to right: nothing is read after it was written.
void add_neighbours(const std::int16_t* sums, int reach, int count, std::int16_t* target) {
  for (int k = 0; k < count; k += kLanes) {
    store(target + k, load<Words>(sums + k) + load<Words>(sums + k + reach));
  }
}

void match_row_pair(GrayView left, GrayView right, int first_row, int pitch, int offset, int cells, int levels,
                    std::int16_t* scratch, std::int16_t* costs, int stride) {
  static_assert(kMatchWidth == 8);
  const int windows_per_cell = pitch / 2;
  for (int d = 0; d < levels; ++d) {
    std::int16_t* const out = costs + static_cast<std::ptrdiff_t>(d) * stride;
    const int first = std::min(cells, (std::max(0, d - offset) + pitch - 1) / pitch);
    const int end = std::clamp((left.width - kMatchWidth - offset) / pitch + 1, first, cells);
    std::fill_n(out, first, kNoPairCost);
    if (first < end) {
      const int x = first * pitch + offset;
      const std::uint8_t* const l[2] = {left.row(first_row) + x, left.row(first_row + 1) + x};
      const std::uint8_t* const r[2] = {right.row(first_row) + x - d, right.row(first_row + 1) + x - d};
      const int windows = (end - first - 1) * windows_per_cell + 1;
      add_column_pairs(l, r, windows + 3, scratch);
      add_neighbours(scratch, 1, windows + 2, scratch);
      if (windows_per_cell == 1) {
        add_neighbours(scratch, 2, windows, out + first);
      } else {
        add_neighbours(scratch, 2, windows, scratch);
        for (int i = first; i < end; ++i) {
          out[i] = scratch[2 * (i - first)];
        }
      }
    }
    std::fill(out + end, out + cells, kNoPairCost);
  }
}

void choose_levels(const std::int16_t* const* pair_costs, int cells, int levels, int stride, std::int16_t* costs,
                   std::int16_t* best, std::int16_t* cost, std::int16_t* second_cost) {
  static_assert(kMatchHeight == 6);
  for (int i = 0; i < cells; i += kLanes) {
    Words least = Words{} + kNoCost;
    Words at{};
    for (int d = 0; d < levels; ++d) {
      const std::ptrdiff_t k = static_cast<std::ptrdiff_t>(d) * stride + i;
      const Words c = load<Words>(pair_costs[0] + k) + load<Words>(pair_costs[1] + k) + load<Words>(pair_costs[2] + k);
      store(costs + k, c);
      const Words level = Words{} + static_cast<std::int16_t>(d);
      at = c < least ? level : at;
      least = c < least ? c : least;
    }
    Words second = Words{} + kNoCost;
    for (int d = 0; d < levels; ++d) {
      const Words c = load<Words>(costs + static_cast<std::ptrdiff_t>(d) * stride + i);
      const Words apart = Words{} + static_cast<std::int16_t>(d) - at;
      second = (((apart > 1) | (apart < -1)) & (c < second)) ? c : second;
    }
    store(best + i, at);
    store(cost + i, least);
    store(second_cost + i, second);
  }
}

/// Pixels of a patch's row, padded.
constexpr int kPatchLanes = 8;
using PatchBytes = std::uint8_t __attribute__((vector_size(kPatchLanes)));
using PatchWords = std::int16_t __attribute__((vector_size(2 * kPatchLanes)));
using PatchInts = std::int32_t __attribute__((vector_size(4 * kPatchLanes)));

PatchWords patch_row(const std::uint8_t* pixels) {
  return __builtin_convertvector(load<PatchBytes>(pixels), PatchWords);
}

float patch_difference(GrayView image, int x, int y, GrayView other, float shift_x, float shift_y) {
  static_assert(kPatchPx == 6);
  const float ox = static_cast<float>(x) + shift_x;
  const float oy = static_cast<float>(y) + shift_y;
  if (!(ox >= 0.F && oy >= 0.F && ox + kPatchPx < static_cast<float>(other.width) &&
        oy + kPatchPx < static_cast<float>(other.height))) {
    return -1.F;
  }
  // In 1/32 of a pixel: all weights together are 1024.
  const int x0 = static_cast<int>(ox);
  const int y0 = static_cast<int>(oy);
  const auto fx = static_cast<std::int16_t>((static_cast<int>(64.F * (ox - static_cast<float>(x0))) + 1) / 2);
  const std::int32_t fy = (static_cast<int>(64.F * (oy - static_cast<float>(y0))) + 1) / 2;
  const auto across = [&](int j) {
    const std::uint8_t* const b = other.row(y0 + j) + x0;
    return patch_row(b) * static_cast<std::int16_t>(32 - fx) + patch_row(b + 1) * fx;
  };
  PatchInts total{};
  PatchInts above = __builtin_convertvector(across(0), PatchInts);
  for (int j = 0; j < kPatchPx; ++j) {
    const PatchInts below = __builtin_convertvector(across(j + 1), PatchInts);
    const PatchInts now = __builtin_convertvector(patch_row(image.row(y + j) + x), PatchInts) << 10;
    const PatchInts apart = now - above * (32 - fy) - below * fy;
    total += apart < 0 ? -apart : apart;
    above = below;
  }
  const int sum = total[0] + total[1] + total[2] + total[3] + total[4] + total[5];
  return static_cast<float>(sum) / (1024.F * static_cast<float>(kPatchPx * kPatchPx));
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

int plane_score(const DisparityPoints& points, const float* plane, float tolerance_px) {
  int score = 0;
  for (int i = 0; i < points.count; ++i) {
    const float off = points.disparity_px[i] - (plane[0] * points.u_px[i] + plane[1] * points.v_px[i] + plane[2]);
    score += (off <= tolerance_px && off >= -tolerance_px ? 1 : 0) - (off < -3.F * tolerance_px ? 1 : 0);
  }
  return score;
}

}  // namespace

extern const DenseKernels kDenseKernels;
const DenseKernels kDenseKernels{decimate,         horizontal_gradient, match_row_pair, choose_levels,
                                 patch_difference, patch_sums,          plane_score};

}  // namespace kinetrace::segmentation::KINETRACE_KERNEL_ISA
// NOLINTEND(bugprone-implicit-widening-of-multiplication-result)
