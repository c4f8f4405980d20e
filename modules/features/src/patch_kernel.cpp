// Sub-pixel alignment of 16 x 11 patches, a vector of pixels at a time.
#include "kernels.hpp"
#include "patch_samples.hpp"
#include "simd.hpp"
#include "small_solver.hpp"

// Offsets within an image fit an int by far.
// NOLINTBEGIN(bugprone-implicit-widening-of-multiplication-result)
namespace kinetrace::features::KINETRACE_KERNEL_ISA {
namespace {

// Positions this far outside the image still read within the padding.
constexpr float kOutside = static_cast<float>(kPadding) - 12.F;

/// Written so that NaN is outside.
inline bool readable(const Plane& plane, float x, float y) {
  return x > -kOutside && y > -kOutside && x < static_cast<float>(plane.width) + kOutside &&
         y < static_cast<float>(plane.height) + kOutside;
}

constexpr int kRowVectors = kPatchWidth / kLanes;

/// The 176 samples of a patch around (x, y): calls use(index of the first, vector within the row, values).
template <typename Use>
inline void sample_patch(const Plane& plane, float x, float y, Use&& use) {
  sample_rows<kRowVectors, kPatchHeight>(plane, x - kPatchHalfWidth, y - kPatchHalfHeight,
                                         [&](int row, const Floats* values) {
                                           for (int k = 0; k < kRowVectors; ++k) {
                                             use(row * kPatchWidth + k * kLanes, k, values[k]);
                                           }
                                         });
}

/// One partial sum per vector of a row: independent chains of additions overlap.
struct RowSums {
  Floats part[kRowVectors] = {};
  [[nodiscard]] float total() const {
    Floats all = part[0];
    for (int k = 1; k < kRowVectors; ++k) {
      all += part[k];
    }
    return sum(all);
  }
};

bool align(const Plane& image, const PatchTemplate& patch, const AlignOptions& options, float* x, float* y) {
  const float hyy = patch.hyy + options.row_weight;
  const float determinant = patch.hxx * hyy - patch.hxy * patch.hxy;
  // One gray level of gradient per pixel in the weakest direction is far below any useful strength.
  if (!(determinant > 1e-4F * patch.hxx * hyy) || !(patch.hxx > 1.F)) {
    return false;
  }
  const float inverse = 1.F / determinant;
  const float start_x = *x;
  const float start_y = *y;
  float at_x = start_x;
  float at_y = start_y;
  for (int iteration = 0; iteration < options.max_iterations; ++iteration) {
    const float shift_x = at_x - start_x;
    const float shift_y = at_y - start_y;
    if (!(shift_x * shift_x + shift_y * shift_y <= options.max_shift_px * options.max_shift_px) ||
        !readable(image, at_x, at_y)) {
      return false;
    }
    RowSums sum_x;
    RowSums sum_y;
    sample_patch(image, at_x, at_y, [&](int index, int k, Floats value) {
      sum_x.part[k] += value * load(patch.gradient_x + index);
      sum_y.part[k] += value * load(patch.gradient_y + index);
    });
    const float bx = sum_x.total();
    const float by = sum_y.total() + options.row_weight * (at_y - options.preferred_row);
    const float step_x = (hyy * bx - patch.hxy * by) * inverse;
    const float step_y = (patch.hxx * by - patch.hxy * bx) * inverse;
    at_x -= step_x;
    at_y -= step_y;
    if (step_x * step_x + step_y * step_y < options.converged_px * options.converged_px) {
      break;
    }
  }
  *x = at_x;
  *y = at_y;
  return readable(image, at_x, at_y);
}

/// Comparison of an image patch with a template.
struct Comparison {
  float mean;
  float gain;
  PatchFit fit;
};

/// Samples into `values` and compares.
template <bool kMasked>
Comparison compare(const Plane& image, const PatchTemplate& patch, float x, float y, float* values) {
  RowSums total;
  RowSums product;
  sample_patch(image, x, y, [&](int index, int k, Floats value) {
    store(values + index, value);
    total.part[k] += masked<kMasked>(value, patch, index);
    product.part[k] += value * load(patch.value + index);
  });
  Comparison result;
  result.mean = total.total() / patch.pixels;
  const Floats mean = splat(result.mean);
  Floats square = splat(0.F);
  for (int i = 0; i < kPatchPixels; i += kLanes) {
    const Floats value = masked<kMasked>(load(values + i) - mean, patch, i);
    square += value * value;
  }
  const float energy = sum(square);
  const float covariance = product.total();
  const bool flat = !(energy > 0.F) || !(patch.energy > 0.F);
  result.gain = flat ? 0.F : covariance / patch.energy;
  const float unexplained = flat ? energy : energy - covariance * result.gain;
  result.fit.correlation = flat ? 0.F : covariance / __builtin_sqrtf(energy * patch.energy);
  result.fit.residual_rms = unexplained > 0.F ? __builtin_sqrtf(unexplained / patch.pixels) : 0.F;
  return result;
}

Comparison compare(const Plane& image, const PatchTemplate& patch, float x, float y, float* values) {
  return patch.whole ? compare<false>(image, patch, x, y, values) : compare<true>(image, patch, x, y, values);
}

PatchFit fit(const Plane& image, const PatchTemplate& patch, float x, float y) {
  alignas(64) float values[kPatchPixels];
  return compare(image, patch, x, y, values).fit;
}

/// Larger steps are outside the linear range.
inline float limited(float v) {
  constexpr float kLimit = 0.15F;
  return v > kLimit ? kLimit : (v < -kLimit ? -kLimit : v);
}

/// Gauss-Newton step of the first kSize entries of (xx, xy, yx, yy).
template <int kSize, bool kMasked>
void warp_step(const PatchTemplate& patch, const float* values, const Comparison& comparison, float prior_weight,
               float (&step)[kSize]) {
  const Floats mean = splat(comparison.mean);
  const Floats inverse_gain = splat(1.F / comparison.gain);
  Floats normal[kSize][kSize];
  Floats right[kSize];
  for (int i = 0; i < kSize; ++i) {
    right[i] = splat(0.F);
    for (int j = 0; j <= i; ++j) {
      normal[i][j] = splat(0.F);
    }
  }
  for (int index = 0; index < kPatchPixels; index += kLanes) {
    const Floats offset_x = ramp(static_cast<float>(index % kPatchWidth) - kPatchHalfWidth);
    const int row = index / kPatchWidth;
    const Floats offset_y = splat(static_cast<float>(row) - kPatchHalfHeight);
    const Floats value = load(patch.value + index);
    const Floats error = masked<kMasked>((load(values + index) - mean) * inverse_gain, patch, index) - value;
    const Floats gradient_x = raw_gradient<kMasked>(patch, patch.gradient_x, patch.raw_x, index);
    const Floats gradient_y = raw_gradient<kMasked>(patch, patch.gradient_y, patch.raw_y, index);
    const Floats jacobian[4] = {gradient_x * offset_x, gradient_x * offset_y, gradient_y * offset_x,
                                gradient_y * offset_y};
    for (int i = 0; i < kSize; ++i) {
      right[i] += jacobian[i] * error;
      for (int j = 0; j <= i; ++j) {
        normal[i][j] += jacobian[i] * jacobian[j];
      }
    }
  }
  float matrix[kSize][kSize];
  for (int i = 0; i < kSize; ++i) {
    step[i] = sum(right[i]);
    for (int j = 0; j <= i; ++j) {
      matrix[i][j] = sum(normal[i][j]) + (i == j ? prior_weight : 0.F);
    }
  }
  solve<kSize>(matrix, step);
}

template <int kSize>
void warp_step(const PatchTemplate& patch, const float* values, const Comparison& comparison, float prior_weight,
               float (&step)[kSize]) {
  if (patch.whole) {
    warp_step<kSize, false>(patch, values, comparison, prior_weight, step);
  } else {
    warp_step<kSize, true>(patch, values, comparison, prior_weight, step);
  }
}

PatchFit refine_warp(const Plane& image, const PatchTemplate& patch, float x, float y, const WarpOptions& options,
                     PatchWarp* warp) {
  alignas(64) float values[kPatchPixels];
  const Comparison comparison = compare(image, patch, x, y, values);
  // A fit this poor has no information on the warp.
  if (comparison.fit.correlation < 0.5F) {
    return comparison.fit;
  }
  float step[4] = {0.F, 0.F, 0.F, 0.F};
  if (options.horizontal_only) {
    float horizontal[2];
    warp_step<2>(patch, values, comparison, options.prior_weight, horizontal);
    step[0] = horizontal[0];
    step[1] = horizontal[1];
  } else {
    warp_step<4>(patch, values, comparison, options.prior_weight, step);
  }
  const float xx = 1.F + limited(step[0]);
  const float xy = limited(step[1]);
  const float yx = limited(step[2]);
  const float yy = 1.F + limited(step[3]);
  *warp = {warp->xx * xx + warp->xy * yx, warp->xx * xy + warp->xy * yy, warp->yx * xx + warp->yy * yx,
           warp->yx * xy + warp->yy * yy};
  return comparison.fit;
}

}  // namespace

extern const PatchKernels kPatchKernels;
const PatchKernels kPatchKernels = {&align, &fit, &refine_warp};

}  // namespace kinetrace::features::KINETRACE_KERNEL_ISA
// NOLINTEND(bugprone-implicit-widening-of-multiplication-result)
