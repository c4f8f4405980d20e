// The inner loop of expose, once per instruction set, with bit-identical results.
#pragma once

#include <cstdint>

namespace kinetrace::simulator {

/// Parameters common to the pixels of one row.
struct RowExposure {
  float exposure = 1.F;
  float centre_x_px = 0.F;
  float from_centre_y_px = 0.F;
  float shading = 0.F;  ///< Fraction of the light lost at one pixel from the centre; grows with the squared distance.
  float noise_levels = 0.F;
  std::uint32_t noise_key = 0;
};

namespace kernel_baseline {
void expose_row(const float* radiance, int width, const RowExposure& row, std::uint8_t* levels) noexcept;
}
namespace kernel_fast {
void expose_row(const float* radiance, int width, const RowExposure& row, std::uint8_t* levels) noexcept;
}  // namespace kernel_fast

}  // namespace kinetrace::simulator
