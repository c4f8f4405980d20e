// A grey or colour picture.
#pragma once

#include <cstdint>

#include "kinetrace/core/image_view.hpp"
#include "kinetrace/core/instance_masks.hpp"

namespace kinetrace::neural {

/// 8-bit samples, 1 or 3 (red, green, blue) a pixel. Does not own them.
struct Picture {
  const std::uint8_t* data = nullptr;
  int width_px = 0;
  int height_px = 0;
  int stride_bytes = 0;
  int channels = 1;

  Picture() = default;
  Picture(const std::uint8_t* samples, int width, int height, int stride, int samples_per_pixel)
      : data(samples), width_px(width), height_px(height), stride_bytes(stride), channels(samples_per_pixel) {}
  Picture(GrayView image)  // NOLINT(google-explicit-constructor): a grey image is a picture.
      : Picture(image.data, image.width, image.height, image.stride, 1) {}

  /// View of a part, which must lie inside.
  [[nodiscard]] Picture part(const PixelBox& box) const noexcept {
    return {row(box.y0) + static_cast<std::ptrdiff_t>(box.x0) * channels, box.width(), box.height(), stride_bytes,
            channels};
  }
  [[nodiscard]] const std::uint8_t* row(int y) const noexcept {
    return data + static_cast<std::ptrdiff_t>(y) * stride_bytes;
  }
};

/// A picture, and the other camera's of the same size in a rectified pair; without it, disparities are unknown.
struct StereoPicture {
  Picture picture;
  Picture other{};
  View view = View::kLeft;  ///< Of `picture`.
};

}  // namespace kinetrace::neural
