// Sub-pixel alignment of 16 x 11 patches, eight pixels at a time.
#include "kernels.hpp"
#include "simd.hpp"

namespace kinetrace::features::KINETRACE_KERNEL_ISA {
namespace {

constexpr int kVectors = kPatchPixels / 8;
// A template needs one more pixel on every side for its gradients.
constexpr int kBorderedHeight = kPatchHeight + 2;
constexpr int kBorderedWidth = kPatchWidth + 2;
constexpr int kBorderedStride = 24;
// Positions this far outside the image still read within the padding.
constexpr float kOutside = static_cast<float>(kPadding) - 12.F;

inline int floor_to_int(float v) {
  const int truncated = static_cast<int>(v);
  return truncated - static_cast<int>(v < static_cast<float>(truncated));
}

/// Written so that NaN is outside.
inline bool readable(const Plane& plane, float x, float y) {
  return x > -kOutside && y > -kOutside && x < static_cast<float>(plane.width) + kOutside &&
         y < static_cast<float>(plane.height) + kOutside;
}

template <int kCount>
inline void interpolate_row(const std::uint8_t* row, Float8 fraction, Float8* out) {
  for (int i = 0; i < kCount; ++i) {
    const Float8 left = load_bytes(row + 8 * i);
    const Float8 right = load_bytes(row + 8 * i + 1);
    out[i] = left + fraction * (right - left);
  }
}

/// Bilinear samples with the first at (x, y): calls use(row, values) for each of `kRows` rows of kCount vectors.
template <int kCount, int kRows, typename Use>
inline void sample_rows(const Plane& plane, float x, float y, Use&& use) {
  const int column = floor_to_int(x);
  const int line = floor_to_int(y);
  const Float8 fraction_x = splat(x - static_cast<float>(column));
  const Float8 fraction_y = splat(y - static_cast<float>(line));
  const std::uint8_t* row = plane.data + static_cast<long>(line) * plane.stride + column;
  Float8 upper[kCount];
  interpolate_row<kCount>(row, fraction_x, upper);
  for (int i = 0; i < kRows; ++i) {
    row += plane.stride;
    Float8 lower[kCount];
    interpolate_row<kCount>(row, fraction_x, lower);
    Float8 values[kCount];
    for (int k = 0; k < kCount; ++k) {
      values[k] = upper[k] + fraction_y * (lower[k] - upper[k]);
      upper[k] = lower[k];
    }
    use(i, values);
  }
}

/// The 176 samples of a patch around (x, y): calls use(index of the first of eight, eight samples).
template <typename Use>
inline void sample_patch(const Plane& plane, float x, float y, Use&& use) {
  sample_rows<2, kPatchHeight>(plane, x - kPatchHalfWidth, y - kPatchHalfHeight, [&](int row, const Float8* values) {
    use(row * kPatchWidth, values[0]);
    use(row * kPatchWidth + 8, values[1]);
  });
}

/// Square root of the smaller eigenvalue of [a b; b c].
inline float minimum_strength(float a, float b, float c) {
  const float half_difference = 0.5F * (a - c);
  const float smaller = 0.5F * (a + c) - __builtin_sqrtf(half_difference * half_difference + b * b);
  return smaller > 0.F ? __builtin_sqrtf(smaller) : 0.F;
}

/// Fills a template from samples with a border of one (stride kBorderedStride).
void make_template(const float* bordered, PatchTemplate* out) {
  Float8 total = splat(0.F);
  Float8 total_x = splat(0.F);
  Float8 total_y = splat(0.F);
  for (int row = 0; row < kPatchHeight; ++row) {
    for (int half = 0; half < kPatchWidth; half += 8) {
      const float* centre = bordered + (row + 1) * kBorderedStride + half + 1;
      const Float8 value = load(centre);
      const Float8 gradient_x = 0.5F * (load(centre + 1) - load(centre - 1));
      const Float8 gradient_y = 0.5F * (load(centre + kBorderedStride) - load(centre - kBorderedStride));
      const int index = row * kPatchWidth + half;
      store(out->value + index, value);
      store(out->gradient_x + index, gradient_x);
      store(out->gradient_y + index, gradient_y);
      total += value;
      total_x += gradient_x;
      total_y += gradient_y;
    }
  }
  constexpr float kPerPixel = 1.F / static_cast<float>(kPatchPixels);
  const Float8 mean = splat(sum(total) * kPerPixel);
  const float mean_x = sum(total_x) * kPerPixel;
  const float mean_y = sum(total_y) * kPerPixel;

  Float8 energy = splat(0.F);
  Float8 along_x = splat(0.F);
  Float8 along_y = splat(0.F);
  for (int i = 0; i < kPatchPixels; i += 8) {
    const Float8 value = load(out->value + i) - mean;
    store(out->value + i, value);
    energy += value * value;
    along_x += value * load(out->gradient_x + i);
    along_y += value * load(out->gradient_y + i);
  }
  out->energy = sum(energy);
  const float inverse_energy = out->energy > 0.F ? 1.F / out->energy : 0.F;
  out->raw_x[0] = sum(along_x) * inverse_energy;
  out->raw_x[1] = mean_x;
  out->raw_y[0] = sum(along_y) * inverse_energy;
  out->raw_y[1] = mean_y;

  const Float8 value_x = splat(out->raw_x[0]);
  const Float8 value_y = splat(out->raw_y[0]);
  const Float8 constant_x = splat(mean_x);
  const Float8 constant_y = splat(mean_y);
  Float8 hxx = splat(0.F);
  Float8 hxy = splat(0.F);
  Float8 hyy = splat(0.F);
  for (int i = 0; i < kPatchPixels; i += 8) {
    const Float8 value = load(out->value + i);
    const Float8 gradient_x = load(out->gradient_x + i) - constant_x - value_x * value;
    const Float8 gradient_y = load(out->gradient_y + i) - constant_y - value_y * value;
    store(out->gradient_x + i, gradient_x);
    store(out->gradient_y + i, gradient_y);
    hxx += gradient_x * gradient_x;
    hxy += gradient_x * gradient_y;
    hyy += gradient_y * gradient_y;
  }
  out->hxx = sum(hxx);
  out->hxy = sum(hxy);
  out->hyy = sum(hyy);
  out->strength = minimum_strength(out->hxx * kPerPixel, out->hxy * kPerPixel, out->hyy * kPerPixel);
}

void sample(const Plane& source, float x, float y, PatchTemplate* out) {
  float bordered[kBorderedHeight * kBorderedStride];
  sample_rows<kBorderedStride / 8, kBorderedHeight>(source, x - kPatchHalfWidth - 1.F, y - kPatchHalfHeight - 1.F,
                                                    [&](int row, const Float8* values) {
                                                      float* target = bordered + row * kBorderedStride;
                                                      store(target, values[0]);
                                                      store(target + 8, values[1]);
                                                      store(target + 16, values[2]);
                                                    });
  make_template(bordered, out);
}

/// True if all samples of a warped patch, with border, can be read: its corners bound them.
bool warp_readable(const Plane& plane, float x, float y, const PatchWarp& warp) {
  constexpr float kX = kPatchHalfWidth + 1.F;
  constexpr float kY = kPatchHalfHeight + 1.F;
  const float reach_x = __builtin_fabsf(warp.xx) * kX + __builtin_fabsf(warp.xy) * kY;
  const float reach_y = __builtin_fabsf(warp.yx) * kX + __builtin_fabsf(warp.yy) * kY;
  const float margin = static_cast<float>(plane.margin);
  return x - reach_x >= -margin && y - reach_y >= -margin &&
         x + reach_x < static_cast<float>(plane.width) + margin - 1.F &&
         y + reach_y < static_cast<float>(plane.height) + margin - 1.F;
}

bool sample_warped(const Plane& source, float x, float y, const PatchWarp& warp, PatchTemplate* out) {
  if (!warp_readable(source, x, y, warp)) {
    return false;
  }
  // 16.16 fixed point, shifted to be positive so that the integer part is a floor.
  constexpr float kOne = 65536.F;
  constexpr int kShift = kPadding + 1;
  const std::int32_t step_x = static_cast<std::int32_t>(warp.xx * kOne);
  const std::int32_t step_y = static_cast<std::int32_t>(warp.yx * kOne);
  const std::uint8_t* origin = source.data - static_cast<long>(kShift) * source.stride - kShift;
  float bordered[kBorderedHeight * kBorderedStride] = {};
  for (int row = 0; row < kBorderedHeight; ++row) {
    const float dy = static_cast<float>(row) - kPatchHalfHeight - 1.F;
    constexpr float kFirst = -kPatchHalfWidth - 1.F;
    std::int32_t at_x = static_cast<std::int32_t>((x + kShift + warp.xx * kFirst + warp.xy * dy) * kOne);
    std::int32_t at_y = static_cast<std::int32_t>((y + kShift + warp.yx * kFirst + warp.yy * dy) * kOne);
    for (int column = 0; column < kBorderedWidth; ++column) {
      const std::uint8_t* pixel = origin + static_cast<long>(at_y >> 16) * source.stride + (at_x >> 16);
      const std::int32_t fraction_x = (at_x & 0xFFFF) >> 8;
      const std::int32_t fraction_y = (at_y & 0xFFFF) >> 8;
      const std::int32_t upper = pixel[0] * 256 + fraction_x * (pixel[1] - pixel[0]);
      const std::int32_t lower =
          pixel[source.stride] * 256 + fraction_x * (pixel[source.stride + 1] - pixel[source.stride]);
      bordered[row * kBorderedStride + column] =
          static_cast<float>(upper * 256 + fraction_y * (lower - upper)) * (1.F / 65536.F);
      at_x += step_x;
      at_y += step_y;
    }
  }
  make_template(bordered, out);
  return true;
}

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
    Float8 sum_x = splat(0.F);
    Float8 sum_y = splat(0.F);
    sample_patch(image, at_x, at_y, [&](int index, Float8 value) {
      sum_x += value * load(patch.gradient_x + index);
      sum_y += value * load(patch.gradient_y + index);
    });
    const float bx = sum(sum_x);
    const float by = sum(sum_y) + options.row_weight * (at_y - options.preferred_row);
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

/// What the patch of an image around a position has in common with a template.
struct Comparison {
  float mean;
  float gain;
  PatchFit fit;
};

/// Samples into `values` and compares.
Comparison compare(const Plane& image, const PatchTemplate& patch, float x, float y, float* values) {
  Float8 total = splat(0.F);
  Float8 product = splat(0.F);
  sample_patch(image, x, y, [&](int index, Float8 value) {
    store(values + index, value);
    total += value;
    product += value * load(patch.value + index);
  });
  Comparison result;
  result.mean = sum(total) / static_cast<float>(kPatchPixels);
  const Float8 mean = splat(result.mean);
  Float8 square = splat(0.F);
  for (int i = 0; i < kPatchPixels; i += 8) {
    const Float8 value = load(values + i) - mean;
    square += value * value;
  }
  const float energy = sum(square);
  const float covariance = sum(product);
  const bool flat = !(energy > 0.F) || !(patch.energy > 0.F);
  result.gain = flat ? 0.F : covariance / patch.energy;
  const float unexplained = flat ? energy : energy - covariance * result.gain;
  result.fit.correlation = flat ? 0.F : covariance / __builtin_sqrtf(energy * patch.energy);
  result.fit.residual_rms = unexplained > 0.F ? __builtin_sqrtf(unexplained / static_cast<float>(kPatchPixels)) : 0.F;
  return result;
}

PatchFit fit(const Plane& image, const PatchTemplate& patch, float x, float y) {
  alignas(64) float values[kPatchPixels];
  return compare(image, patch, x, y, values).fit;
}

/// Solves the symmetric positive definite system a x = b in place by Cholesky decomposition; b becomes x.
template <int kSize>
void solve(float (&a)[kSize][kSize], float (&b)[kSize]) {
  for (int i = 0; i < kSize; ++i) {
    for (int j = 0; j <= i; ++j) {
      float value = a[i][j];
      for (int k = 0; k < j; ++k) {
        value -= a[i][k] * a[j][k];
      }
      a[i][j] = i == j ? __builtin_sqrtf(value > 1e-6F ? value : 1e-6F) : value / a[j][j];
    }
  }
  for (int i = 0; i < kSize; ++i) {
    for (int k = 0; k < i; ++k) {
      b[i] -= a[i][k] * b[k];
    }
    b[i] /= a[i][i];
  }
  for (int i = kSize - 1; i >= 0; --i) {
    for (int k = i + 1; k < kSize; ++k) {
      b[i] -= a[k][i] * b[k];
    }
    b[i] /= a[i][i];
  }
}

inline float limited(float v) {
  constexpr float kLimit = 0.15F;
  return v > kLimit ? kLimit : (v < -kLimit ? -kLimit : v);
}

/// Gauss-Newton step of the first kSize entries of (xx, xy, yx, yy).
template <int kSize>
void warp_step(const PatchTemplate& patch, const float* values, const Comparison& comparison, float prior_weight,
               float (&step)[kSize]) {
  const Float8 lane = {-7.5F, -6.5F, -5.5F, -4.5F, -3.5F, -2.5F, -1.5F, -0.5F};
  const Float8 mean = splat(comparison.mean);
  const Float8 inverse_gain = splat(1.F / comparison.gain);
  Float8 normal[kSize][kSize];
  Float8 right[kSize];
  for (int i = 0; i < kSize; ++i) {
    right[i] = splat(0.F);
    for (int j = 0; j <= i; ++j) {
      normal[i][j] = splat(0.F);
    }
  }
  for (int index = 0; index < kPatchPixels; index += 8) {
    const Float8 offset_x = lane + static_cast<float>(index % kPatchWidth);
    const Float8 offset_y = splat(static_cast<float>(index / kPatchWidth) - kPatchHalfHeight);
    const Float8 value = load(patch.value + index);
    const Float8 error = (load(values + index) - mean) * inverse_gain - value;
    const Float8 gradient_x = load(patch.gradient_x + index) + patch.raw_x[0] * value + patch.raw_x[1];
    const Float8 gradient_y = load(patch.gradient_y + index) + patch.raw_y[0] * value + patch.raw_y[1];
    const Float8 jacobian[4] = {gradient_x * offset_x, gradient_x * offset_y, gradient_y * offset_x,
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

PatchFit refine_warp(const Plane& image, const PatchTemplate& patch, float x, float y, const WarpOptions& options,
                     PatchWarp* warp) {
  alignas(64) float values[kPatchPixels];
  const Comparison comparison = compare(image, patch, x, y, values);
  // A fit this poor says nothing about the warp.
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
const PatchKernels kPatchKernels = {&sample, &sample_warped, &align, &fit, &refine_warp};

}  // namespace kinetrace::features::KINETRACE_KERNEL_ISA
