// Small pictures that the kernels work on directly.
#pragma once

#include <cstdint>
#include <vector>

#include <Eigen/Core>

#include "image_pyramid.hpp"
#include "kernel_types.hpp"
#include "synthetic_scene.hpp"

namespace kinetrace::features::testing {

inline constexpr int kPictureWidth = 240;
inline constexpr int kPictureHeight = 80;
/// Alignment settings for tests of hundredths of a pixel.
inline constexpr AlignOptions kExactly{
    .max_iterations = 20, .converged_px = 0.003F, .max_shift_px = 4.F, .preferred_row = 0.F, .row_weight = 0.F};

/// An image ready for the kernels.
class Picture {
 public:
  explicit Picture(const PixelValue& value, double noise_gray = 0.0, unsigned seed = 1) {
    const Image image = render(kPictureWidth, kPictureHeight, value, noise_gray, seed);
    std::vector<std::uint16_t> scratch(kPictureWidth + 32);
    pyramid_.build(image.view(), scratch);
  }
  [[nodiscard]] Plane plane() const { return pyramid_.level(0); }

 private:
  Arena arena_{std::size_t{1} << 17};
  ImagePyramid pyramid_{arena_, kPictureWidth, kPictureHeight, 1};
};

/// A surface that ends at a column, and the background beyond.
inline PixelValue surface(const Texture& own, double contour_x, const Eigen::Vector2d& shift,
                          const PixelValue& beyond) {
  return [&own, contour_x, shift, beyond](const Eigen::Vector2d& p) {
    return p.x() < contour_x + shift.x() ? own(p - shift) : beyond(p);
  };
}

}  // namespace kinetrace::features::testing
