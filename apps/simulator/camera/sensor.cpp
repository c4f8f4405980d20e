#include "camera/sensor.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "camera/sensor_kernel.hpp"
#include "kinetrace/core/cpu.hpp"
#include "util/parallel.hpp"
#include "util/random.hpp"

namespace kinetrace::simulator {
namespace {

constexpr int kBlurRadius_px = 2;
using BlurWeights = std::array<float, kBlurRadius_px + 1>;

BlurWeights gaussian(double sigma_px) {
  BlurWeights weights{};
  float sum = 0.F;
  for (int i = 0; i <= kBlurRadius_px; ++i) {
    weights[static_cast<std::size_t>(i)] = static_cast<float>(std::exp(-0.5 * i * i / (sigma_px * sigma_px)));
    sum += (i == 0 ? 1.F : 2.F) * weights[static_cast<std::size_t>(i)];
  }
  for (float& weight : weights) {
    weight /= sum;
  }
  return weights;
}

float weighted(const BlurWeights& weights, float middle, float near_sum, float far_sum) {
  float sum = weights[0] * middle;
  sum += weights[1] * near_sum;
  sum += weights[2] * far_sum;
  return sum;
}

// The two directions of the separable blur; edges repeat.
Image<float> blurred_along_rows(const Image<float>& source, const BlurWeights& weights, int threads) {
  Image<float> target(source.width(), source.height());
  const int last = source.width() - 1;
  for_each_index(source.height(), threads, [&](int y) {
    const float* from = &source.at(0, y);
    float* to = &target.at(0, y);
    const auto blur_at = [&](int x) {
      return weighted(weights, from[x], from[std::max(x - 1, 0)] + from[std::min(x + 1, last)],
                      from[std::max(x - 2, 0)] + from[std::min(x + 2, last)]);
    };
    for (int x = 0; x < std::min(kBlurRadius_px, last + 1); ++x) {
      to[x] = blur_at(x);
    }
    for (int x = kBlurRadius_px; x <= last - kBlurRadius_px; ++x) {
      to[x] = weighted(weights, from[x], from[x - 1] + from[x + 1], from[x - 2] + from[x + 2]);
    }
    for (int x = std::max(last - kBlurRadius_px + 1, kBlurRadius_px); x <= last; ++x) {
      to[x] = blur_at(x);
    }
  });
  return target;
}

Image<float> blurred_along_columns(const Image<float>& source, const BlurWeights& weights, int threads) {
  Image<float> target(source.width(), source.height());
  for_each_index(source.height(), threads, [&](int y) {
    const auto row = [&](int dy) { return &source.at(0, std::clamp(y + dy, 0, source.height() - 1)); };
    const std::array<const float*, 5> rows{row(-2), row(-1), row(0), row(1), row(2)};
    float* to = &target.at(0, y);
    for (int x = 0; x < source.width(); ++x) {
      to[x] = weighted(weights, rows[2][x], rows[1][x] + rows[3][x], rows[0][x] + rows[4][x]);
    }
  });
  return target;
}

using Kernel = decltype(&kernel_baseline::expose_row);

Kernel best_kernel() {
  return cpu_runs_fast_kernels() ? &kernel_fast::expose_row : &kernel_baseline::expose_row;
}

}  // namespace

Image<std::uint8_t> expose(Image<float> radiance, const SensorSettings& settings, double exposure, std::uint32_t stream,
                           int threads) {
  if (settings.blur_px > 0.0) {
    const BlurWeights weights = gaussian(settings.blur_px);
    radiance = blurred_along_columns(blurred_along_rows(radiance, weights, threads), weights, threads);
  }
  const int width = radiance.width();
  const int height = radiance.height();
  Image<std::uint8_t> image(width, height);
  const auto centre_x = 0.5F * static_cast<float>(width - 1);
  const auto centre_y = 0.5F * static_cast<float>(height - 1);
  const float shading = static_cast<float>(settings.vignetting) / (centre_x * centre_x + centre_y * centre_y);
  const Kernel expose_row = best_kernel();
  for_each_index(height, threads, [&](int y) {
    const RowExposure row{static_cast<float>(exposure),
                          centre_x,
                          static_cast<float>(y) - centre_y,
                          shading,
                          static_cast<float>(settings.noise_levels),
                          hash_of(stream, y)};
    expose_row(&radiance.at(0, y), width, row, &image.at(0, y));
  });
  return image;
}

}  // namespace kinetrace::simulator
