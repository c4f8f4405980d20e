// Compiled for each instruction set; see kinetrace_kernel.
#include "camera/sensor_kernel.hpp"

#include "util/lanes.hpp"
#include "util/random.hpp"

namespace kinetrace::simulator::KINETRACE_KERNEL_ISA {
namespace {

constexpr IntVector kRamp = {0, 1, 2, 3, 4, 5, 6, 7};

// Nearly normal, unit variance: the sum of four uniform bytes (central limit theorem); at 0.4 % of a grey level's
// steps.
Floats noise_from(WordVector bits) noexcept {
  const WordVector sum = (bits & 255U) + ((bits >> 8U) & 255U) + ((bits >> 16U) & 255U) + (bits >> 24U);
  constexpr float kDeviation = 147.8F;  // sqrt(4 * (256^2 - 1) / 12)
  return (to_floats(to_ints(sum)) - 510.F) / kDeviation;
}

// Grey levels of the pixels from column `x` on.
IntVector exposed(Floats radiance, int x, const RowExposure& row) noexcept {
  const IntVector columns = kRamp + x;
  const Floats dx = to_floats(columns) - row.centre_x_px;
  const Floats lens = 1.F - row.shading * (dx * dx + row.from_centre_y_px * row.from_centre_y_px);
  const Floats light = max(radiance * lens * row.exposure, 0.F);
  // The response is a square root, which makes shot noise equal at all levels; read noise grows with the slope of the
  // response, towards the dark.
  const Floats level = 255.F * sqrt(light);
  const Floats read = 128.F / max(level, 24.F);
  const Floats deviation = row.noise_levels * sqrt(0.5F + 0.5F * min(read * read, 2.F));
  const Floats value = level + deviation * noise_from(mixed(row.noise_key + to_words(columns) * 0x9e3779b9U));
  return truncated(clamp(value + 0.5F, 0.F, 255.F));
}

// At most eight pixels.
inline void expose_some(const float* radiance, int x, int count, const RowExposure& row,
                        std::uint8_t* levels) noexcept {
  Floats light(0.F);
  __builtin_memcpy(&light.v, radiance + x, static_cast<std::size_t>(count) * sizeof(float));
  const IntVector grey = exposed(light, x, row);
  for (int i = 0; i < count; ++i) {
    levels[x + i] = static_cast<std::uint8_t>(grey[i]);
  }
}

}  // namespace

void expose_row(const float* radiance, int width, const RowExposure& row, std::uint8_t* levels) noexcept {
  int x = 0;
  for (; x + kLanes <= width; x += kLanes) {
    expose_some(radiance, x, kLanes, row, levels);
  }
  expose_some(radiance, x, width - x, row, levels);
}

}  // namespace kinetrace::simulator::KINETRACE_KERNEL_ISA
