#include "shading/noise.hpp"

#include <algorithm>
#include <cmath>
#include <iterator>

#include "shading/shading_kernel.hpp"

namespace kinetrace::simulator {
namespace {

// Variance of one octave: that of a uniform value in [-1, 1], times the mean sum of the squared weights of quintic
// interpolation (362 / 462) for each of three directions.
constexpr float kOctaveVariance = (1.F / 3.F) * 0.78355F * 0.78355F * 0.78355F;

}  // namespace

Octaves::Octaves(float largest_cell_m, float gain, int octaves_count, std::uint32_t octaves_seed)
    : count(octaves_count), seed(octaves_seed) {
  float power = 0.F;
  for (int i = 0; i < count; ++i) {
    frequency[i] = std::ldexp(1.F / largest_cell_m, i);
    amplitude[i] = std::pow(gain, static_cast<float>(i));
    power += amplitude[i] * amplitude[i];
  }
  const float scale = 1.F / std::sqrt(power * kOctaveVariance);
  std::transform(std::begin(amplitude), std::end(amplitude), std::begin(amplitude), [&](float a) { return a * scale; });
}

Lanes fractal_noise(const Octaves& octaves, const Lanes3& points, const Lanes& footprint_m) {
  Lanes result;
  shading_kernel().noise(octaves, points, footprint_m, result);
  return result;
}

}  // namespace kinetrace::simulator
