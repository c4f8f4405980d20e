// Templates of 16 x 11 patches: samples and gradients, ready for alignment with another image.
#include "kernels.hpp"
#include "patch_samples.hpp"
#include "simd.hpp"

// Offsets within an image fit an int by far.
// NOLINTBEGIN(bugprone-implicit-widening-of-multiplication-result)
namespace kinetrace::features::KINETRACE_KERNEL_ISA {
namespace {

// A template needs one more pixel on every side for its gradients.
constexpr int kBorderedHeight = kPatchHeight + 2;
constexpr int kBorderedWidth = kPatchWidth + 2;
constexpr int kBorderedStride = 24;

/// Square root of the smaller eigenvalue of [a b; b c].
inline float minimum_strength(float a, float b, float c) {
  const float half_difference = 0.5F * (a - c);
  const float smaller = 0.5F * (a + c) - __builtin_sqrtf(half_difference * half_difference + b * b);
  return smaller > 0.F ? __builtin_sqrtf(smaller) : 0.F;
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

/// Means over the samples that count.
struct PatchMeans {
  float value;
  float gradient_x;
  float gradient_y;
};

/// Writes samples and gradients of a template with given weights, from samples with a border of one (stride
/// kBorderedStride).
template <bool kMasked>
PatchMeans take_samples(const float* bordered, float per_pixel, PatchTemplate* out) {
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
  return {sum(total) * per_pixel, sum(total_x) * per_pixel, sum(total_y) * per_pixel};
}

/// Removes the mean of the samples, and computes the parts of the gradients to be removed.
template <bool kMasked>
void centre(const PatchMeans& means, PatchTemplate* out) {
  const Floats mean = splat(means.value);
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
  out->raw_x[1] = means.gradient_x;
  out->raw_y[0] = sum(along_y) * inverse_energy;
  out->raw_y[1] = means.gradient_y;
}

/// Makes the gradients orthogonal to the samples and to a constant.
template <bool kMasked>
void orthogonalise(PatchTemplate* out) {
  const Floats value_x = splat(out->raw_x[0]);
  const Floats value_y = splat(out->raw_y[0]);
  const Floats mean_x = splat(out->raw_x[1]);
  const Floats mean_y = splat(out->raw_y[1]);
  Floats hxx = splat(0.F);
  Floats hxy = splat(0.F);
  Floats hyy = splat(0.F);
  for (int i = 0; i < kPatchPixels; i += kLanes) {
    const Floats value = load(out->value + i);
    const Floats constant_x = masked<kMasked>(mean_x, *out, i);
    const Floats constant_y = masked<kMasked>(mean_y, *out, i);
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
}

/// Fills a template with given weights.
template <bool kMasked>
void make_template(const float* bordered, PatchTemplate* out) {
  const float per_pixel = 1.F / out->pixels;
  const PatchMeans means = take_samples<kMasked>(bordered, per_pixel, out);
  centre<kMasked>(means, out);
  orthogonalise<kMasked>(out);
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
      // Columns beyond the patch repeat the last one, to avoid reading further.
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

/// Coefficients of the gradient orthogonal to the samples and to a constant under the window: gradient - mean - along *
/// (value - mean_value).
struct WindowFit {
  float mean_value;
  float mean_x, mean_y;
  float along_x, along_y;
};

/// False where no sample counts.
template <bool kMasked>
bool fit_window(const PatchTemplate& patch, WindowFit* fit) {
  Floats weights = splat(0.F);
  Floats values = splat(0.F);
  Floats squares = splat(0.F);
  Floats total_x = splat(0.F);
  Floats total_y = splat(0.F);
  Floats along_x = splat(0.F);
  Floats along_y = splat(0.F);
  for_window<kMasked>(patch, [&](int index, Floats weight) {
    const Floats value = load(patch.value + index);
    const Floats weighted_x = weight * raw_gradient<kMasked>(patch, patch.gradient_x, patch.raw_x, index);
    const Floats weighted_y = weight * raw_gradient<kMasked>(patch, patch.gradient_y, patch.raw_y, index);
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
    return false;
  }
  const float mean = sum(values) / all;
  const float mean_x = sum(total_x) / all;
  const float mean_y = sum(total_y) / all;
  const float energy = sum(squares) - all * mean * mean;
  const float inverse_energy = energy > 0.F ? 1.F / energy : 0.F;
  *fit = {mean, mean_x, mean_y, (sum(along_x) - all * mean * mean_x) * inverse_energy,
          (sum(along_y) - all * mean * mean_y) * inverse_energy};
  return true;
}

template <bool kMasked>
void narrow(PatchTemplate* patch) {
  WindowFit fit;
  if (!fit_window<kMasked>(*patch, &fit)) {
    return;
  }
  Floats hxx = splat(0.F);
  Floats hxy = splat(0.F);
  Floats hyy = splat(0.F);
  for_window<kMasked>(*patch, [&](int index, Floats weight) {
    const Floats value = load(patch->value + index);
    const Floats raw_x = raw_gradient<kMasked>(*patch, patch->gradient_x, patch->raw_x, index);
    const Floats raw_y = raw_gradient<kMasked>(*patch, patch->gradient_y, patch->raw_y, index);
    const Floats x = raw_x - fit.mean_x - fit.along_x * (value - fit.mean_value);
    const Floats y = raw_y - fit.mean_y - fit.along_y * (value - fit.mean_value);
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

extern const PatchTemplateKernels kPatchTemplateKernels;
const PatchTemplateKernels kPatchTemplateKernels = {&sample, &sample_warped, &narrow};

}  // namespace kinetrace::features::KINETRACE_KERNEL_ISA
// NOLINTEND(bugprone-implicit-widening-of-multiplication-result)
