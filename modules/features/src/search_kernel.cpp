// Exhaustive searches: by correlation in two dimensions, by absolute differences along a row.
#include "kernels.hpp"
#include "simd.hpp"

// Offsets within an image fit an int by far.
// NOLINTBEGIN(bugprone-implicit-widening-of-multiplication-result)
namespace kinetrace::features::KINETRACE_KERNEL_ISA {
namespace {

// Sixteen offsets are evaluated at once, up to sixteen beyond the last one wanted.
constexpr int kRegionStride = kPatchWidth + 2 * kMaxSearchRadius + 16;
constexpr int kRegionHeight = kPatchHeight + 2 * kMaxSearchRadius;

constexpr int kOffsets = 16;  // Neighbouring offsets in x, evaluated at once.
constexpr int kVectors = kOffsets / kLanes;

/// Vertical sums over as many rows as a patch has, slid down row by row.
struct ColumnSums {
  alignas(64) float total[kRegionStride];
  alignas(64) float square[kRegionStride];

  void add(const float* row, int columns, float sign) {
    for (int x = 0; x < columns; x += kLanes) {
      const Floats value = load(row + x);
      store(total + x, load(total + x) + sign * value);
      store(square + x, load(square + x) + sign * value * value);
    }
  }
};

/// Correlation of the template with the patches at kOffsets offsets in x.
void correlate_row(const float* region, const ColumnSums& columns, int first, const PatchTemplate& patch,
                   float* correlations) {
  // Two partial sums for each vector of offsets: more chains of additions overlap.
  Floats product[2][kVectors] = {};
  for (int row = 0; row < kPatchHeight; ++row) {
    for (int column = 0; column < kPatchWidth; column += 2) {
      const float* values = region + row * kRegionStride + first + column;
      const float* weights = patch.value + row * kPatchWidth + column;
      for (int k = 0; k < kVectors; ++k) {
        product[0][k] += weights[0] * load(values + k * kLanes);
        product[1][k] += weights[1] * load(values + k * kLanes + 1);
      }
    }
  }
  for (int k = 0; k < kVectors; ++k) {
    Floats total = splat(0.F);
    Floats square = splat(0.F);
    for (int column = 0; column < kPatchWidth; ++column) {
      total += load(columns.total + first + k * kLanes + column);
      square += load(columns.square + first + k * kLanes + column);
    }
    constexpr float kPixels = static_cast<float>(kPatchPixels);
    const Floats energy = square - total * total * (1.F / kPixels);
    // With less than a gray level of contrast, any correlation is possible by chance.
    const Floats correlation =
        (product[0][k] + product[1][k]) / square_root(energy > kPixels ? energy * patch.energy : splat(1e30F));
    store(correlations + k * kLanes, correlation);
  }
}

OffsetMatch correlate(const Plane& image, const PatchTemplate& patch, int x, int y, int radius_x, int radius_y) {
  // Gray relative to 128 keeps the sums of squares small, hence exact enough.
  alignas(64) float region[kRegionHeight * kRegionStride];
  ColumnSums columns = {};
  const int rows = kPatchHeight + 2 * radius_y;
  const int width = kPatchWidth + 2 * radius_x;
  const std::uint8_t* corner = image.data + static_cast<long>(y - kPatchHeight / 2 - radius_y) * image.stride + x -
                               kPatchWidth / 2 + 1 - radius_x;
  for (int row = 0; row < rows; ++row) {
    for (int column = 0; column < width; column += kLanes) {
      store(region + row * kRegionStride + column,
            load_bytes(corner + static_cast<long>(row) * image.stride + column) - 128.F);
    }
  }
  for (int row = 0; row < kPatchHeight - 1; ++row) {
    columns.add(region + row * kRegionStride, width, 1.F);
  }
  OffsetMatch best = {0, 0, -1.F};
  for (int dy = 0; dy <= 2 * radius_y; ++dy) {
    columns.add(region + (dy + kPatchHeight - 1) * kRegionStride, width, 1.F);
    for (int first = 0; first < 2 * radius_x; first += kOffsets) {
      float correlations[kOffsets];
      correlate_row(region + dy * kRegionStride, columns, first, patch, correlations);
      for (int i = 0; i < kOffsets && first + i < 2 * radius_x; ++i) {
        if (correlations[i] > best.correlation) {
          best = {first + i - radius_x, dy - radius_y, correlations[i]};
        }
      }
    }
    columns.add(region + dy * kRegionStride, width, -1.F);
  }
  return best;
}

void row_costs(const Plane& from, int x, int y, const Plane& to, int to_y, int first, int count, std::uint16_t* costs) {
  constexpr int kLeft = kPatchWidth / 2 - 1;
  constexpr int kUp = kPatchHeight / 2;
  using Patch = BytePatch<kPatchHeight>;
  Patch patch;
  const std::uint8_t* source = from.data + static_cast<long>(y - kUp) * from.stride + x - kLeft;
  for (int row = 0; row < kPatchHeight; ++row) {
    __builtin_memcpy(patch.rows[row], source + static_cast<long>(row) * from.stride, kPatchWidth);
  }
  const std::uint8_t* target = to.data + static_cast<long>(to_y - kUp) * to.stride + first - kLeft;
  // Blocks of kAtOnce * 16 offsets; offsets 16 apart are compared together.
  constexpr int kBlock = Patch::kAtOnce * kPatchWidth;
  unsigned sums[Patch::kAtOnce];
  for (int block = 0; block < count; block += kBlock) {
    const int end = count - block < kPatchWidth ? count - block : kPatchWidth;
    for (int k = block; k < block + end; ++k) {
      patch.differences(target + k, to.stride, sums);
      for (int i = 0; i < Patch::kAtOnce; ++i) {
        if (k + i * kPatchWidth < count) {
          costs[k + i * kPatchWidth] = static_cast<std::uint16_t>(sums[i]);
        }
      }
    }
  }
}

}  // namespace

extern const SearchKernels kSearchKernels;
const SearchKernels kSearchKernels = {&correlate, &row_costs};

}  // namespace kinetrace::features::KINETRACE_KERNEL_ISA
// NOLINTEND(bugprone-implicit-widening-of-multiplication-result)
