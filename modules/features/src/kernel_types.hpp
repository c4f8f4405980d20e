// Plain data shared by the kernels and their callers. Kernel sources are compiled once per instruction set, so this
// file must not contain inline code that a linker could merge across sets.
#pragma once

#include <cstdint>

namespace kinetrace::features {

inline constexpr int kPatchWidth = 16;
inline constexpr int kPatchHeight = 11;
inline constexpr int kPatchPixels = kPatchWidth * kPatchHeight;
/// Distance of the outermost sample from the patch's centre: the patch spans an even number of columns.
inline constexpr float kPatchHalfWidth = 7.5F;
inline constexpr float kPatchHalfHeight = 5.F;

/// Replicated pixels around every pyramid level, so that patches and searches may overlap the border unchecked.
inline constexpr int kPadding = 32;

/// 8-bit pixels; `data` points at pixel (0, 0), and `margin` pixels on every side of the image may be read as well.
struct Plane {
  const std::uint8_t* data;
  int width;
  int height;
  int stride;
  int margin;
};

/// Position in a source image; between nodes that are kWarpBlock pixels apart it is linear.
struct WarpNode {
  float u, v;
};
inline constexpr int kWarpBlock = 16;

/// Offset in the source image = matrix * offset in the target image, both from the patch's centre.
struct PatchWarp {
  float xx, xy, yx, yy;
};

/// Which samples of a patch count. Bit k of a row is column k.
struct PatchMask {
  std::uint16_t rows[kPatchHeight];
  bool whole;  ///< True if all count.
};

/// A patch ready to be aligned with another image. `gradient_x`, `gradient_y` are orthogonal to the patch itself and to
/// a constant: alignment is invariant to gain and offset. All three are zero outside the patch's mask. After narrowing,
/// the gradients are orthogonal under the window, and weighted by it.
struct alignas(64) PatchTemplate {
  float value[kPatchPixels];  ///< Zero mean.
  float gradient_x[kPatchPixels];
  float gradient_y[kPatchPixels];
  float weight[kPatchPixels];  ///< 1 where the mask is set, else 0. Only filled if not `whole`.
  float raw_x[2], raw_y[2];    ///< Gradient before orthogonalisation = gradient + raw[0] * value + raw[1] * weight.
  float energy;                ///< Sum of value^2.
  float hxx, hxy, hyy;         ///< Sums of products of the gradients.
  float strength;              ///< Root of the smaller eigenvalue of the matrix above, per pixel.
  float pixels;                ///< Number of samples that count.
  bool whole;                  ///< True if all count.
};

/// Options of an alignment.
struct AlignOptions {
  int max_iterations;
  float converged_px;
  float max_shift_px;   ///< Largest distance from the start, beyond which alignment fails.
  float preferred_row;  ///< Prior: y near this row...
  float row_weight;     ///< ...with this weight (gray^2 / px^2); 0 for none.
};

/// Quality of a template's fit at a position.
struct PatchFit {
  float correlation;   ///< Zero-mean, normalised.
  float residual_rms;  ///< Gray, after gain and offset.
};

/// Options of a warp refinement.
struct WarpOptions {
  float prior_weight;    ///< Of the prior for no change, gray^2 per unit of the matrix squared.
  bool horizontal_only;  ///< Rows stay rows: only xx and xy change.
};

/// Largest radius of SearchKernels::correlate.
inline constexpr int kMaxSearchRadius = 16;

struct OffsetMatch {
  int dx;
  int dy;
  float correlation;
};

}  // namespace kinetrace::features
