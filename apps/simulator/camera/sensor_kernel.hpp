// The inner loop of expose, once per instruction set; all give the same to the last bit.
#pragma once

#include <cstdint>

namespace kinetrace::simulator {

/// What the pixels of one row share.
struct RowExposure {
  float exposure = 1.F;
  float centre_x_px = 0.F;
  float from_centre_y_px = 0.F;
  float shading = 0.F;  ///< Part of the light that is lost a pixel from the centre; grows with the square.
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
