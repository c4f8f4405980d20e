#include "noise.hpp"

#include <algorithm>
#include <cmath>

#include "kinetrace/core/cpu.hpp"
#include "noise_kernel.hpp"

namespace kinetrace::simulator {
namespace {

// Variance of one octave: that of a uniform value in [-1, 1], times the mean sum of the squared weights of quintic
// interpolation (362 / 462) for each of three directions.
constexpr float kOctaveVariance = (1.F / 3.F) * 0.78355F * 0.78355F * 0.78355F;

// Where the kernel lets even the largest cells fade out.
constexpr float kSwallowed = 0.95F;

using Kernel = decltype(&kernel_baseline::fractal_noise);

Kernel best_kernel() {
#ifdef KINETRACE_HAVE_V3
  if (cpu_has_v3()) {
    return &kernel_v3::fractal_noise;
  }
#endif
  return &kernel_baseline::fractal_noise;
}

}  // namespace

Octaves::Octaves(float largest_cell_m, float gain, int count, std::uint32_t octaves_seed) : seed(octaves_seed) {
  float power = 0.F;
  for (std::size_t i = 0; i < kCount; ++i) {
    frequency[i] = std::ldexp(1.F / largest_cell_m, static_cast<int>(i));
    amplitude[i] = static_cast<int>(i) < count ? std::pow(gain, static_cast<float>(i)) : 0.F;
    power += amplitude[i] * amplitude[i];
  }
  const float scale = 1.F / std::sqrt(power * kOctaveVariance);
  std::transform(amplitude.begin(), amplitude.end(), amplitude.begin(), [&](float a) { return a * scale; });
}

float fractal_noise(const Octaves& octaves, const Eigen::Vector3f& point, float footprint_m) {
  static const Kernel kernel = best_kernel();
  if (octaves.frequency[0] * footprint_m > kSwallowed) {
    return 0.F;
  }
  return kernel(octaves.frequency.data(), octaves.amplitude.data(), octaves.seed, point.x(), point.y(), point.z(),
                footprint_m);
}

}  // namespace kinetrace::simulator
