// Sub-pixel alignment of 16 x 11 patches, a vector of pixels at a time.
#include "kernels.hpp"
#include "simd.hpp"
#include "small_solver.hpp"

// Offsets within an image fit an int by far.
// NOLINTBEGIN(bugprone-implicit-widening-of-multiplication-result)
namespace kinetrace::features::KINETRACE_KERNEL_ISA {
namespace {

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
inline void interpolate_row(const std::uint8_t* row, Floats fraction, Floats* out) {
  for (int i = 0; i < kCount; ++i) {
    const Floats left = load_bytes(row + kLanes * i);
    const Floats right = load_bytes(row + kLanes * i + 1);
    out[i] = left + fraction * (right - left);
  }
}

/// Bilinear samples with the first at (x, y): calls use(row, values) for each of `kRows` rows of kCount vectors.
template <int kCount, int kRows, typename Use>
inline void sample_rows(const Plane& plane, float x, float y, Use&& use) {
  const int column = floor_to_int(x);
  const int line = floor_to_int(y);
  const Floats fraction_x = splat(x - static_cast<float>(column));
  const Floats fraction_y = splat(y - static_cast<float>(line));
  const std::uint8_t* row = plane.data + static_cast<long>(line) * plane.stride + column;
  Floats upper[kCount];
  interpolate_row<kCount>(row, fraction_x, upper);
  for (int i = 0; i < kRows; ++i) {
    row += plane.stride;
    Floats lower[kCount];
    interpolate_row<kCount>(row, fraction_x, lower);
    Floats values[kCount];
    for (int k = 0; k < kCount; ++k) {
      values[k] = upper[k] + fraction_y * (lower[k] - upper[k]);
      upper[k] = lower[k];
    }
    use(i, values);
  }
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

/// Square root of the smaller eigenvalue of [a b; b c].
inline float minimum_strength(float a, float b, float c) {
  const float half_difference = 0.5F * (a - c);
  const float smaller = 0.5F * (a + c) - __builtin_sqrtf(half_difference * half_difference + b * b);
  return smaller > 0.F ? __builtin_sqrtf(smaller) : 0.F;
}

/// Samples that do not count are zero.
template <bool kMasked>
inline Floats masked(Floats value, const PatchTemplate& patch, int index) {
  return kMasked ? value * load(patch.weight + index) : value;
}

/// The gradient as it was before it was made orthogonal to the patch and to a constant. `raw` belongs to `gradient`.
template <bool kMasked>
inline Floats raw_gradient(const PatchTemplate& patch, const float* gradient, const float (&raw)[2], int index) {
  return load(gradient + index) + raw[0] * load(patch.value + index) + masked<kMasked>(splat(raw[1]), patch, index);
}

void expand(const PatchMask& mask, PatchTemplate* out) {
  out->whole = mask.whole;
  out->pixels = static_cast<float>(kPatchPixels);
  if (mask.whole) {
    return;
  }
  int count = 0;
  for (int row = 0; row < kPatchHeight; ++row) {
    count += __builtin_popcount(mask.rows[row]);
    for (int column = 0; column < kPatchWidth; ++column) {
      out->weight[row * kPatchWidth + column] = (mask.rows[row] >> column & 1) != 0 ? 1.F : 0.F;
    }
  }
  out->pixels = static_cast<float>(count);
}

/// Fills a template, its weights given, from samples with a border of one (stride kBorderedStride).
template <bool kMasked>
void make_template(const float* bordered, PatchTemplate* out) {
  Floats total = splat(0.F);
  Floats total_x = splat(0.F);
  Floats total_y = splat(0.F);
  for (int row = 0; row < kPatchHeight; ++row) {
    for (int half = 0; half < kPatchWidth; half += kLanes) {
      const float* centre = bordered + (row + 1) * kBorderedStride + half + 1;
      const int index = row * kPatchWidth + half;
      const Floats value = masked<kMasked>(load(centre), *out, index);
      const Floats gradient_x = masked<kMasked>(0.5F * (load(centre + 1) - load(centre - 1)), *out, index);
      const Floats gradient_y =
          masked<kMasked>(0.5F * (load(centre + kBorderedStride) - load(centre - kBorderedStride)), *out, index);
      store(out->value + index, value);
      store(out->gradient_x + index, gradient_x);
      store(out->gradient_y + index, gradient_y);
      total += value;
      total_x += gradient_x;
      total_y += gradient_y;
    }
  }
  const float per_pixel = 1.F / out->pixels;
  const Floats mean = splat(sum(total) * per_pixel);
  const float mean_x = sum(total_x) * per_pixel;
  const float mean_y = sum(total_y) * per_pixel;

  Floats energy = splat(0.F);
  Floats along_x = splat(0.F);
  Floats along_y = splat(0.F);
  for (int i = 0; i < kPatchPixels; i += kLanes) {
    const Floats value = load(out->value + i) - masked<kMasked>(mean, *out, i);
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

  const Floats value_x = splat(out->raw_x[0]);
  const Floats value_y = splat(out->raw_y[0]);
  Floats hxx = splat(0.F);
  Floats hxy = splat(0.F);
  Floats hyy = splat(0.F);
  for (int i = 0; i < kPatchPixels; i += kLanes) {
    const Floats value = load(out->value + i);
    const Floats constant_x = masked<kMasked>(splat(mean_x), *out, i);
    const Floats constant_y = masked<kMasked>(splat(mean_y), *out, i);
    const Floats gradient_x = load(out->gradient_x + i) - constant_x - value_x * value;
    const Floats gradient_y = load(out->gradient_y + i) - constant_y - value_y * value;
    store(out->gradient_x + i, gradient_x);
    store(out->gradient_y + i, gradient_y);
    hxx += gradient_x * gradient_x;
    hxy += gradient_x * gradient_y;
    hyy += gradient_y * gradient_y;
  }
  out->hxx = sum(hxx);
  out->hxy = sum(hxy);
  out->hyy = sum(hyy);
  out->strength = minimum_strength(out->hxx * per_pixel, out->hxy * per_pixel, out->hyy * per_pixel);
}

void make_template(const float* bordered, const PatchMask& mask, PatchTemplate* out) {
  expand(mask, out);
  if (mask.whole) {
    make_template<false>(bordered, out);
  } else {
    make_template<true>(bordered, out);
  }
}

void sample(const Plane& source, float x, float y, const PatchMask& mask, PatchTemplate* out) {
  alignas(64) float bordered[kBorderedHeight * kBorderedStride];
  sample_rows<kBorderedStride / kLanes, kBorderedHeight>(
      source, x - kPatchHalfWidth - 1.F, y - kPatchHalfHeight - 1.F, [&](int row, const Floats* values) {
        for (int k = 0; k < kBorderedStride / kLanes; ++k) {
          store(bordered + row * kBorderedStride + k * kLanes, values[k]);
        }
      });
  make_template(bordered, mask, out);
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

inline Floats interpolate_pairs(Ints pairs, Floats fraction) {
  const Floats left = __builtin_convertvector(pairs & 0xFF, Floats);
  const Floats right = __builtin_convertvector((pairs >> 8) & 0xFF, Floats);
  return left + fraction * (right - left);
}

bool sample_warped(const Plane& source, float x, float y, const PatchWarp& warp, const PatchMask& mask,
                   PatchTemplate* out) {
  if (!warp_readable(source, x, y, warp)) {
    return false;
  }
  // Shifted to be positive, so that truncation is a floor.
  constexpr float kShift = static_cast<float>(kPadding) + 1.F;
  const std::uint8_t* origin = source.data - (kPadding + 1) * static_cast<long>(source.stride) - (kPadding + 1);
  alignas(64) float bordered[kBorderedHeight * kBorderedStride];
  for (int row = 0; row < kBorderedHeight; ++row) {
    const float dy = static_cast<float>(row) - kPatchHalfHeight - 1.F;
    for (int column = 0; column < kBorderedWidth; column += kLanes) {
      // Columns beyond those in use repeat the last one, so as not to read further.
      const Floats last = splat(static_cast<float>(kBorderedWidth - 1));
      Floats dx = ramp(static_cast<float>(column));
      dx = (dx > last ? last : dx) - (kPatchHalfWidth + 1.F);
      const Floats at_x = warp.xx * dx + (x + kShift + warp.xy * dy);
      const Floats at_y = warp.yx * dx + (y + kShift + warp.yy * dy);
      const Ints pixel_x = __builtin_convertvector(at_x, Ints);
      const Ints pixel_y = __builtin_convertvector(at_y, Ints);
      const Floats fraction_x = at_x - __builtin_convertvector(pixel_x, Floats);
      const Floats fraction_y = at_y - __builtin_convertvector(pixel_y, Floats);
      const Ints offsets = multiply_small(pixel_y, source.stride) + pixel_x;
      const Floats upper = interpolate_pairs(gather_pairs(origin, offsets), fraction_x);
      const Floats lower = interpolate_pairs(gather_pairs(origin + source.stride, offsets), fraction_x);
      store(bordered + row * kBorderedStride + column, upper + fraction_y * (lower - upper));
    }
  }
  make_template(bordered, mask, out);
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

/// What the patch of an image around a position has in common with a template.
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

/// A larger step is no small correction any more.
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

/// (1 - r^2)^4 along one side of the patch: nearly a Gaussian, of 3 columns or 2.1 rows, but zero from `reach` on.
template <int kCount>
struct Bell {
  float at[kCount];
  constexpr Bell(float half_extent, float reach) : at{} {
    for (int i = 0; i < kCount; ++i) {
      const float r = (static_cast<float>(i) - half_extent) / reach;
      const float rest = 1.F - r * r;
      at[i] = rest * rest * rest * rest;
    }
  }
};
constexpr Bell<kPatchWidth> kBellOfColumns(kPatchHalfWidth, kPatchHalfWidth + 1.F);
constexpr Bell<kPatchHeight> kBellOfRows(kPatchHalfHeight, kPatchHalfHeight + 1.F);

/// Calls use(index of the first, weights) for all samples of a patch.
template <bool kMasked, typename Use>
inline void for_window(const PatchTemplate& patch, Use&& use) {
  for (int row = 0; row < kPatchHeight; ++row) {
    const Floats of_row = splat(kBellOfRows.at[row]);
    for (int column = 0; column < kPatchWidth; column += kLanes) {
      const int index = row * kPatchWidth + column;
      use(index, masked<kMasked>(of_row * load(kBellOfColumns.at + column), patch, index));
    }
  }
}

template <bool kMasked>
void narrow(PatchTemplate* patch) {
  const auto gradient_x = [patch](int index) {
    return raw_gradient<kMasked>(*patch, patch->gradient_x, patch->raw_x, index);
  };
  const auto gradient_y = [patch](int index) {
    return raw_gradient<kMasked>(*patch, patch->gradient_y, patch->raw_y, index);
  };
  Floats weights = splat(0.F);
  Floats values = splat(0.F);
  Floats squares = splat(0.F);
  Floats total_x = splat(0.F);
  Floats total_y = splat(0.F);
  Floats along_x = splat(0.F);
  Floats along_y = splat(0.F);
  for_window<kMasked>(*patch, [&](int index, Floats weight) {
    const Floats value = load(patch->value + index);
    const Floats weighted_x = weight * gradient_x(index);
    const Floats weighted_y = weight * gradient_y(index);
    weights += weight;
    values += weight * value;
    squares += weight * value * value;
    total_x += weighted_x;
    total_y += weighted_y;
    along_x += weighted_x * value;
    along_y += weighted_y * value;
  });
  const float all = sum(weights);
  if (!(all > 0.F)) {
    return;
  }
  const float mean = sum(values) / all;
  const float mean_x = sum(total_x) / all;
  const float mean_y = sum(total_y) / all;
  const float energy = sum(squares) - all * mean * mean;
  const float inverse_energy = energy > 0.F ? 1.F / energy : 0.F;
  const float value_x = (sum(along_x) - all * mean * mean_x) * inverse_energy;
  const float value_y = (sum(along_y) - all * mean * mean_y) * inverse_energy;

  Floats hxx = splat(0.F);
  Floats hxy = splat(0.F);
  Floats hyy = splat(0.F);
  for_window<kMasked>(*patch, [&](int index, Floats weight) {
    const Floats value = load(patch->value + index);
    const Floats x = gradient_x(index) - mean_x - value_x * (value - mean);
    const Floats y = gradient_y(index) - mean_y - value_y * (value - mean);
    store(patch->gradient_x + index, weight * x);
    store(patch->gradient_y + index, weight * y);
    hxx += weight * x * x;
    hxy += weight * x * y;
    hyy += weight * y * y;
  });
  patch->hxx = sum(hxx);
  patch->hxy = sum(hxy);
  patch->hyy = sum(hyy);
}

void narrow(PatchTemplate* patch) {
  if (patch->whole) {
    narrow<false>(patch);
  } else {
    narrow<true>(patch);
  }
}

}  // namespace

extern const PatchKernels kPatchKernels;
const PatchKernels kPatchKernels = {&sample, &sample_warped, &align, &fit, &refine_warp, &narrow};

}  // namespace kinetrace::features::KINETRACE_KERNEL_ISA
// NOLINTEND(bugprone-implicit-widening-of-multiplication-result)
