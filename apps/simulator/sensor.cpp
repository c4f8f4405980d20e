#include "sensor.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "parallel.hpp"
#include "random.hpp"

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

// Nearly normal, unit variance: the sum of four uniform bytes (central limit theorem); at 0.4 % of a grey level's
// steps.
float noise_from(std::uint32_t bits) {
  const std::uint32_t sum = (bits & 255U) + ((bits >> 8U) & 255U) + ((bits >> 16U) & 255U) + (bits >> 24U);
  constexpr float kDeviation = 147.8F;  // sqrt(4 * (256^2 - 1) / 12)
  return (static_cast<float>(sum) - 510.F) / kDeviation;
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
  const auto noise = static_cast<float>(settings.noise_levels);
  for_each_index(height, threads, [&](int y) {
    const float dy = static_cast<float>(y) - centre_y;
    const std::uint32_t row_key = hash_of(stream, y);
    for (int x = 0; x < width; ++x) {
      const float dx = static_cast<float>(x) - centre_x;
      const float lens = 1.F - shading * (dx * dx + dy * dy);
      const float light = std::max(radiance.at(x, y) * lens * static_cast<float>(exposure), 0.F);
      // The response is a square root, under which shot noise is the same at every level; read noise grows as the
      // slope of the response, towards the dark.
      const float level = 255.F * std::sqrt(light);
      const float read = 128.F / std::max(level, 24.F);
      const float deviation = noise * std::sqrt(0.5F + 0.5F * std::min(read * read, 2.F));
      const float value = level + deviation * noise_from(mixed(row_key + static_cast<std::uint32_t>(x) * 0x9e3779b9U));
      image.at(x, y) = static_cast<std::uint8_t>(std::clamp(value + 0.5F, 0.F, 255.F));
    }
  });
  return image;
}

}  // namespace kinetrace::simulator
