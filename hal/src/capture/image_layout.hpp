// Size of an image in bytes, as a device delivers it.
#pragma once

#include <cstddef>

#include "capture/capture_device.hpp"

namespace kinetrace::hal {

/// Bytes of one pixel's luminance with interleaved data; zero for compressed formats.
[[nodiscard]] constexpr int bytes_per_pixel(PixelFormat format) noexcept {
  switch (format) {
    case PixelFormat::kGrey8:
    case PixelFormat::kNv12: return 1;
    case PixelFormat::kGrey10:
    case PixelFormat::kGrey16:
    case PixelFormat::kYuyv: return 2;
    case PixelFormat::kMjpeg: return 0;
  }
  return 0;
}

/// Bytes from the first luminance to the last; one for compressed images, which must not be empty.
[[nodiscard]] constexpr std::size_t bytes_needed(const CaptureInfo& info) noexcept {
  const int pixel = bytes_per_pixel(info.format);
  if (pixel == 0) {
    return 1;
  }
  return static_cast<std::size_t>(info.stride_bytes) * static_cast<std::size_t>(info.height_px - 1) +
         static_cast<std::size_t>(pixel) * static_cast<std::size_t>(info.width_px);
}

}  // namespace kinetrace::hal
