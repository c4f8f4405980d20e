// Images of a textured wall.
#pragma once

#include <cstdint>
#include <vector>

namespace kinetrace::hal::test {

/// Pixels of a `width` x `height` image of it, moved right and down on it by so many pixels.
[[nodiscard]] std::vector<std::uint8_t> wall(int width, int height, double right_px, double down_px);

}  // namespace kinetrace::hal::test
