// The loops over whole images of motion segmentation, once for each instruction set.
#pragma once

#include <cstdint>

#include "kinetrace/core/image_view.hpp"

namespace kinetrace::segmentation {

/// Window of a stereo match, in pixels of the matching images.
inline constexpr int kMatchWidth = 8;
inline constexpr int kMatchHeight = 6;

/// Elements past the end of a row that vectors reach.
inline constexpr int kMatchSpill = 32;
/// Cost of a level that cannot be matched.
inline constexpr std::int16_t kNoCost = 0x7FFF;

/// Side of a patch that is compared between frames, in pixels of the matching images.
inline constexpr int kPatchPx = 6;

/// Sums over a patch of what least squares need to align it: gradients and differences.
struct PatchSums {
  float xx = 0.F;  ///< Gradient along x, squared...
  float xy = 0.F;
  float yy = 0.F;
  float xr = 0.F;  ///< ...and times the grey difference `other` - `image`.
  float yr = 0.F;
  float rr = 0.F;
};

struct DenseKernels {
  /// `target` = mean of step x step pixels of `source` (step 1 or 2).
  void (*decimate)(GrayView source, int step, MutableGrayView target);
  /// 128 + (image(x + 1) - image(x - 1)), saturated at 128 +- 63.
  void (*horizontal_gradient)(GrayView image, MutableGrayView target);
  /// One row of cells: costs[d * stride + i] = sum of absolute differences of left's window around column i * pitch +
  /// offset and right's, d pixels further left; kNoCost where that lies outside. `columns` holds
  /// the image's width and kMatchSpill more; rows may be read so far beyond their end.
  void (*match_row)(GrayView left, GrayView right, int first_row, int pitch, int offset, int cells, int levels,
                    std::int16_t* columns, std::int16_t* costs, int stride);
  /// Best level of each cell, its cost, and the least cost of levels that are not its neighbours. `stride` and the
  /// results' length are multiples of 16, at least `cells`.
  void (*choose_levels)(const std::int16_t* costs, int cells, int levels, int stride, std::int16_t* best,
                        std::int16_t* cost, std::int16_t* rival);
  /// Mean absolute grey difference of the patch of `image` with its corner at (x, y) and that of `other`, displaced;
  /// negative where that lies outside.
  float (*patch_difference)(GrayView image, int x, int y, GrayView other, float shift_x, float shift_y);
  /// Sums over the same patch, with the gradients of `other`; false, and nothing written, where that lies outside.
  bool (*patch_sums)(GrayView image, int x, int y, GrayView other, float shift_x, float shift_y, PatchSums& sums);
};

/// The best set for this machine.
[[nodiscard]] const DenseKernels& dense_kernels() noexcept;
/// The portable set.
[[nodiscard]] const DenseKernels& baseline_dense_kernels() noexcept;

}  // namespace kinetrace::segmentation
