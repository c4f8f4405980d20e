// The hot loops behind tables of functions: one set per instruction set, chosen at run time.
#pragma once

#include <cstdint>

#include "kernel_types.hpp"

namespace kinetrace::features {

/// Whole-image passes.
struct PyramidKernels {
  /// Half-size image by a 4 x 4 binomial filter: target pixel (x, y) is centred on source (2x + .5, 2y + .5).
  /// `scratch` holds 2 * width + 2 elements.
  void (*downsample)(const Plane& source, std::uint8_t* target, int width, int height, int stride,
                     std::uint16_t* scratch);
  /// 128 + Sobel x / 4, saturated.
  void (*horizontal_gradient)(const Plane& source, std::uint8_t* target, int stride);
};

/// Templates of 16 x 11 patches.
struct PatchTemplateKernels {
  /// Samples `source` around (x, y), which must lie within the image. At least one sample of `mask` is set.
  void (*sample)(const Plane& source, float x, float y, const PatchMask& mask, PatchTemplate* out);
  /// The same through a warp. False when a sample would fall outside the image and its margin.
  bool (*sample_warped)(const Plane& source, float x, float y, const PatchWarp& warp, const PatchMask& mask,
                        PatchTemplate* out);
  /// Restricts alignment to the centre of the patch: a window weights its samples, falling to zero at the rim.
  /// Afterwards the template is valid for `align` and `fit` only. Unchanged if no samples of the centre count.
  void (*narrow)(PatchTemplate* patch);
};

/// Sub-pixel alignment of an image with a template.
struct PatchKernels {
  /// Inverse-compositional Gauss-Newton over the translation (Baker and Matthews 2004). False when it leaves the
  /// neighbourhood of the start, or the template has too little texture.
  bool (*align)(const Plane& image, const PatchTemplate& patch, const AlignOptions& options, float* x, float* y);
  PatchFit (*fit)(const Plane& image, const PatchTemplate& patch, float x, float y);
  /// One Gauss-Newton step of the warp the template was sampled with, the translation held.
  PatchFit (*refine_warp)(const Plane& image, const PatchTemplate& patch, float x, float y, const WarpOptions& options,
                          PatchWarp* warp);
};

/// Exhaustive searches.
struct SearchKernels {
  /// The integer offset from (x, y), in [-radius_x, radius_x) and [-radius_y, radius_y], where `patch` correlates best.
  /// Radii are at most kMaxSearchRadius.
  OffsetMatch (*correlate)(const Plane& image, const PatchTemplate& patch, int x, int y, int radius_x, int radius_y);
  /// costs[k] = sum of absolute differences between the patch of `from` around (x, y) and that of `to` around
  /// (first + k, to_y). Integer centre: columns x - 7..x + 8, rows y - 5..y + 5. Reads up to 16 pixels further right.
  void (*row_costs)(const Plane& from, int x, int y, const Plane& to, int to_y, int first, int count,
                    std::uint16_t* costs);
};

/// Corners: the smaller eigenvalue of the mean gradient matrix over 5 x 5 pixels (Shi and Tomasi 1994).
struct CornerKernels {
  /// Adds (sign 1) or removes (sign -1) row `y` to the column sums: three arrays of the image's width.
  void (*accumulate_row)(const Plane& image, int y, int sign, std::int32_t* xx, std::int32_t* xy, std::int32_t* yy);
  /// Eigenvalues at x in [x0, x1), (gray / px)^2, from column sums over five rows. Writes up to 7 elements past x1.
  void (*eigenvalue_row)(const std::int32_t* xx, const std::int32_t* xy, const std::int32_t* yy, int x0, int x1,
                         float* eigenvalues);
  /// Columns in [x0, x1) where `row` is at least `threshold` and not below its eight neighbours. Returns how many.
  int (*find_maxima)(const float* above, const float* row, const float* below, int x0, int x1, float threshold,
                     std::uint16_t* columns);
};

/// Warping of images for a slightly rotated camera.
struct WarpKernels {
  /// One row of `width` pixels, bilinear; `nodes` are the positions in `image` of every kWarpBlock-th pixel, one beyond
  /// the last block included. Border pixels are repeated outside `image`.
  void (*warp_row)(const Plane& image, const WarpNode* nodes, int width, std::uint8_t* target);
};

struct Kernels {
  PyramidKernels pyramid;
  PatchTemplateKernels patch_template;
  PatchKernels patch;
  SearchKernels search;
  CornerKernels corner;
  WarpKernels warp;
};

/// The best set for this machine; see cpu_runs_fast_kernels.
[[nodiscard]] const Kernels& kernels() noexcept;
/// The portable set.
[[nodiscard]] const Kernels& baseline_kernels() noexcept;

}  // namespace kinetrace::features
