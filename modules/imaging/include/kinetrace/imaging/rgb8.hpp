// A pixel in colour.
#pragma once

#include <cstdint>

namespace kinetrace::imaging {

struct Rgb8 {
  std::uint8_t r = 0;
  std::uint8_t g = 0;
  std::uint8_t b = 0;
};

}  // namespace kinetrace::imaging
