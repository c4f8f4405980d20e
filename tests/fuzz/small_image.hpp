// An image for recordings whose pixels do not matter.
#pragma once

#include <string>

namespace kinetrace::fuzz {

/// A PGM file.
[[nodiscard]] inline std::string small_image(int width_px = 48, int height_px = 32) {
  return "P5 " + std::to_string(width_px) + " " + std::to_string(height_px) + " 255\n" +
         std::string(static_cast<std::size_t>(width_px) * static_cast<std::size_t>(height_px), '\x7f');
}

}  // namespace kinetrace::fuzz
