#include <algorithm>
#include <bit>
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
using PatchBytes = std::uint8_t __attribute__((vector_size(2 * kPatchLanes)));
using PatchWords = std::uint16_t __attribute__((vector_size(2 * kPatchLanes)));
using Ints = std::int32_t __attribute__((vector_size(4 * kPatchLanes)));
using Floats = float __attribute__((vector_size(4 * kPatchLanes)));

PatchWords patch_row(const std::uint8_t* pixels) {
  static_assert(std::endian::native == std::endian::little);
  using Eight = std::uint64_t __attribute__((vector_size(2 * kPatchLanes)));
  const auto bytes = reinterpret_cast<PatchBytes>(Eight{load<std::uint64_t>(pixels), 0});
  // One instruction, unlike __builtin_convertvector.
  return reinterpret_cast<PatchWords>(
      __builtin_shufflevector(bytes, PatchBytes{}, 0, 16, 1, 17, 2, 18, 3, 19, 4, 20, 5, 21, 6, 22, 7, 23));
}

Floats patch_row_floats(const std::uint8_t* pixels) {
  return __builtin_convertvector(__builtin_convertvector(patch_row(pixels), Ints), Floats);
}

/// Of the lanes that hold a patch's pixels.
template <typename Vector>
auto patch_sum(Vector v) {
  static_assert(kPatchPx == 6);
  return v[0] + v[1] + v[2] + v[3] + v[4] + v[5];
}

/// Corner of a displaced patch, in whole pixels and their fraction.
struct PatchCorner {
  bool inside = false;
  int x = 0;
  int y = 0;
  float fraction_x = 0.F;
  float fraction_y = 0.F;
};

PatchCorner displaced(int x, int y, float shift_x, float shift_y, GrayView image) {
  const float ox = static_cast<float>(x) + shift_x;
  const float oy = static_cast<float>(y) + shift_y;
  if (!(ox >= 0.F && oy >= 0.F && ox + kPatchPx < static_cast<float>(image.width) &&
        oy + kPatchPx < static_cast<float>(image.height))) {
    return {};
  }
  const int x0 = static_cast<int>(ox);
  const int y0 = static_cast<int>(oy);
  return {true, x0, y0, ox - static_cast<float>(x0), oy - static_cast<float>(y0)};
}

float patch_difference(GrayView image, int x, int y, GrayView other, float shift_x, float shift_y) {
  const PatchCorner corner = displaced(x, y, shift_x, shift_y, other);
  if (!corner.inside) {
    return -1.F;
  }
  // Weights in 1/32 of a pixel, grey levels in 1/256, differences in 1/32: what fits 16 bits.
  const auto fx = static_cast<std::uint16_t>((static_cast<int>(64.F * corner.fraction_x) + 1) / 2);
  const auto fy = static_cast<std::uint16_t>((static_cast<int>(64.F * corner.fraction_y) + 1) / 2);
  const auto rest_x = static_cast<std::uint16_t>(32 - fx);
  const auto rest_y = static_cast<std::uint16_t>(32 - fy);
  const auto across = [&](int j) {
    const std::uint8_t* const b = other.row(corner.y + j) + corner.x;
    return (patch_row(b) * rest_x + patch_row(b + 1) * fx + 2) >> 2;
  };
  PatchWords total{};
  PatchWords above = across(0);
  for (int j = 0; j < kPatchPx; ++j) {
    const PatchWords below = across(j + 1);
    const PatchWords now = patch_row(image.row(y + j) + x) << 8;
    const PatchWords then = above * rest_y + below * fy;
    total += ((now > then ? now : then) - (now > then ? then : now)) >> 3;
    above = below;
  }
  return static_cast<float>(patch_sum(__builtin_convertvector(total, Ints))) /
         static_cast<float>(32 * kPatchPx * kPatchPx);
}

bool patch_sums(GrayView image, int x, int y, GrayView other, float shift_x, float shift_y, PatchSums& sums) {
  const PatchCorner corner = displaced(x, y, shift_x, shift_y, other);
  if (!corner.inside) {
    return false;
  }
  const float a = corner.fraction_x;
  const float b = corner.fraction_y;
  Floats xx{};
  Floats xy{};
  Floats yy{};
  Floats xr{};
  Floats yr{};
  Floats rr{};
  for (int j = 0; j < kPatchPx; ++j) {
    const std::uint8_t* const upper = other.row(corner.y + j) + corner.x;
    const std::uint8_t* const lower = other.row(corner.y + j + 1) + corner.x;
    const Floats p00 = patch_row_floats(upper);
    const Floats p10 = patch_row_floats(lower);
    const Floats above = patch_row_floats(upper + 1) - p00;
    const Floats below = patch_row_floats(lower + 1) - p10;
    const Floats top = p00 + a * above;
    const Floats gx = (1.F - b) * above + b * below;
    const Floats gy = p10 + a * below - top;
    const Floats r = top + b * gy - patch_row_floats(image.row(y + j) + x);
    xx += gx * gx;
    xy += gx * gy;
    yy += gy * gy;
    xr += gx * r;
    yr += gy * r;
    rr += r * r;
  }
  sums = {patch_sum(xx), patch_sum(xy), patch_sum(yy), patch_sum(xr), patch_sum(yr), patch_sum(rr)};
  return true;
}

int plane_score(const DisparityPoints& points, const float* plane, float tolerance_px) {
  // Comparisons are -1 where true.
  Ints scores{};
  int i = 0;
  for (; i + kPatchLanes <= points.count; i += kPatchLanes) {
    const Floats off = load<Floats>(points.disparity_px + i) - plane[0] * load<Floats>(points.u_px + i) -
                       plane[1] * load<Floats>(points.v_px + i) - plane[2];
    scores += (off < -3.F * tolerance_px) - ((off <= tolerance_px) & (off >= -tolerance_px));
  }
  int total = 0;
  for (int k = 0; k < kPatchLanes; ++k) {
    total += scores[k];
  }
  for (; i < points.count; ++i) {
    const float off = points.disparity_px[i] - plane[0] * points.u_px[i] - plane[1] * points.v_px[i] - plane[2];
    total += (off <= tolerance_px && off >= -tolerance_px ? 1 : 0) - (off < -3.F * tolerance_px ? 1 : 0);
  }
  return total;
}

}  // namespace

extern const DenseKernels kDenseKernels;
const DenseKernels kDenseKernels{decimate,         horizontal_gradient, match_row_pair, choose_levels,
                                 patch_difference, patch_sums,          plane_score};

}  // namespace kinetrace::segmentation::KINETRACE_KERNEL_ISA
// NOLINTEND(bugprone-implicit-widening-of-multiplication-result)
