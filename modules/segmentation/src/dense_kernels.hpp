// Whole-image loops of motion segmentation, one set per instruction set.
#pragma once

#include <cstdint>

#include "kinetrace/core/image_view.hpp"

namespace kinetrace::segmentation {

/// Window of a stereo match, in pixels of the matching images.
inline constexpr int kMatchWidth = 8;
inline constexpr int kMatchHeight = 6;

/// Elements past the end of a row that vectors may access.
inline constexpr int kMatchSpill = 64;
/// Rows matched at a time; the cost of two rows at a level that cannot be matched; the same for a whole window.
inline constexpr int kMatchedRows = 2;
inline constexpr std::int16_t kNoPairCost = 0x2000;
inline constexpr std::int16_t kNoCost = kMatchHeight / kMatchedRows * kNoPairCost;

/// Side of a patch for comparison between frames, in pixels of the matching images.
inline constexpr int kPatchPx = 6;

/// Sums over a patch for its least-squares alignment: gradients and differences.
struct PatchSums {
  float xx = 0.F;  ///< Gradient along x, squared...
  float xy = 0.F;
  float yy = 0.F;
  float xr = 0.F;  ///< ...and times the grey difference `other` - `image`.
  float yr = 0.F;
  float rr = 0.F;
};

/// Pixels with a disparity.
struct DisparityPoints {
  const float* u_px = nullptr;
  const float* v_px = nullptr;
  const float* disparity_px = nullptr;
  int count = 0;
};

struct DenseKernels {
  /// `target` = mean of step x step pixels of `source` (step 1 or 2).
  void (*decimate)(GrayView source, int step, MutableGrayView target);
  /// 128 + (image(x + 1) - image(x - 1)), saturated at 128 +- 63.
  void (*horizontal_gradient)(GrayView image, MutableGrayView target);
  /// Two rows of a row of cells: costs[d * stride + i] = sum of absolute differences of left's window around column i *
  /// pitch + offset and right's, d pixels further left; kNoPairCost outside the image. `pitch` is 2 or 4; `scratch`
  /// holds half the image's width plus kMatchSpill; rows of images and costs are accessed up to kMatchSpill beyond
  /// their end.
  void (*match_row_pair)(GrayView left, GrayView right, int first_row, int pitch, int offset, int cells, int levels,
                         std::int16_t* scratch, std::int16_t* costs, int stride);
  /// `costs` = sum of the window's three pairs of rows; best level of each cell, its cost, and the least cost of levels
  /// that are not its neighbours. `stride` and the results' length are multiples of 16, at least `cells`.
  void (*choose_levels)(const std::int16_t* const* pair_costs, int cells, int levels, int stride, std::int16_t* costs,
                        std::int16_t* best, std::int16_t* cost, std::int16_t* second_cost);
  /// Mean absolute grey difference of the patch of `image` with its corner at (x, y) and that of `other`, displaced;
  /// negative if it lies outside. Reads two pixels beyond the patch: images need an extra row.
  float (*patch_difference)(GrayView image, int x, int y, GrayView other, float shift_x, float shift_y);
  /// Sums over the same patch, with the gradients of `other`; false, and nothing written, if it lies outside.
  bool (*patch_sums)(GrayView image, int x, int y, GrayView other, float shift_x, float shift_y, PatchSums& sums);
  /// Number of points with the disparity of `plane` (by u, by v, constant) within the tolerance, less those beyond it
  /// by more than three times as much.
  int (*plane_score)(const DisparityPoints& points, const float* plane, float tolerance_px);
};

/// The best set for this machine.
[[nodiscard]] const DenseKernels& dense_kernels() noexcept;
/// The portable set.
[[nodiscard]] const DenseKernels& baseline_dense_kernels() noexcept;

}  // namespace kinetrace::segmentation
