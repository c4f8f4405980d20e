// From light to grey levels: lens shading, blur, gain, response and noise.
#pragma once

#include <cstdint>

#include "util/image.hpp"

namespace kinetrace::simulator {

struct SensorSettings {
  double noise_levels = 1.5;  ///< Standard deviation at half range, in grey levels: half shot, half read noise.
  double vignetting = 0.2;    ///< Fraction of the light lost in the corners.
  double blur_px = 0.35;      ///< Standard deviation of the lens's blur.
  double right_gain = 1.04;   ///< Sensitivity of the right camera relative to the left one.
};

/// The picture that a camera takes. `stream` identifies the noise: frame and camera.
[[nodiscard]] Image<std::uint8_t> expose(Image<float> radiance, const SensorSettings& settings, double exposure,
                                         std::uint32_t stream, int threads);

}  // namespace kinetrace::simulator
