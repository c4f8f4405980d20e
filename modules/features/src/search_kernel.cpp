// Exhaustive searches: by correlation in two dimensions, by absolute differences along a row.
#include "kernels.hpp"
#include "simd.hpp"

namespace kinetrace::features::KINETRACE_KERNEL_ISA {
namespace {

constexpr int kRegionStride = (kPatchWidth + 2 * kMaxSearchRadius + 7) / 8 * 8;
constexpr int kRegionHeight = kPatchHeight + 2 * kMaxSearchRadius;

float correlation_at(const float* region, const PatchTemplate& patch) {
  Float8 total = splat(0.F);
  Float8 square = splat(0.F);
  Float8 product = splat(0.F);
  for (int row = 0; row < kPatchHeight; ++row) {
    for (int half = 0; half < kPatchWidth; half += 8) {
      const Float8 value = load(region + row * kRegionStride + half);
      total += value;
      square += value * value;
      product += value * load(patch.value + row * kPatchWidth + half);
    }
  }
  const float mean = sum(total) / static_cast<float>(kPatchPixels);
  const float energy = sum(square) - mean * mean * static_cast<float>(kPatchPixels);
  // Less than a gray level of contrast correlates with anything.
  if (!(energy > static_cast<float>(kPatchPixels))) {
    return 0.F;
  }
  return sum(product) / __builtin_sqrtf(energy * patch.energy);
}

OffsetMatch correlate(const Plane& image, const PatchTemplate& patch, int x, int y, int radius_x, int radius_y) {
  // Gray relative to 128 keeps the sums of squares small, hence exact enough.
  alignas(64) float region[kRegionHeight * kRegionStride];
  const int rows = kPatchHeight + 2 * radius_y;
  const int columns = kPatchWidth + 2 * radius_x;
  const std::uint8_t* corner = image.data + static_cast<long>(y - kPatchHeight / 2 - radius_y) * image.stride + x -
                               kPatchWidth / 2 + 1 - radius_x;
  for (int row = 0; row < rows; ++row) {
    for (int column = 0; column < columns; column += 8) {
      store(region + row * kRegionStride + column,
            load_bytes(corner + static_cast<long>(row) * image.stride + column) - 128.F);
    }
  }
  OffsetMatch best = {0, 0, -1.F};
  if (!(patch.energy > 0.F)) {
    return best;
  }
  for (int dy = 0; dy <= 2 * radius_y; ++dy) {
    for (int dx = 0; dx <= 2 * radius_x; ++dx) {
      const float correlation = correlation_at(region + dy * kRegionStride + dx, patch);
      if (correlation > best.correlation) {
        best = {dx - radius_x, dy - radius_y, correlation};
      }
    }
  }
  return best;
}

void row_costs(const Plane& from, int x, int y, const Plane& to, int to_y, int direction, int first, int count,
               std::uint16_t* costs) {
  constexpr int kLeft = kPatchWidth / 2 - 1;
  constexpr int kUp = kPatchHeight / 2;
  alignas(16) std::uint8_t patch[kPatchPixels];
  const std::uint8_t* source = from.data + static_cast<long>(y - kUp) * from.stride + x - kLeft;
  for (int row = 0; row < kPatchHeight; ++row) {
    __builtin_memcpy(patch + row * kPatchWidth, source + static_cast<long>(row) * from.stride, kPatchWidth);
  }
  const std::uint8_t* target = to.data + static_cast<long>(to_y - kUp) * to.stride + x - kLeft + direction * first;
  for (int k = 0; k < count; ++k) {
    costs[k] = static_cast<std::uint16_t>(
        absolute_difference(patch, kPatchWidth, target + direction * k, to.stride, kPatchHeight));
  }
}

}  // namespace

extern const SearchKernels kSearchKernels;
const SearchKernels kSearchKernels = {&correlate, &row_costs};

}  // namespace kinetrace::features::KINETRACE_KERNEL_ISA
