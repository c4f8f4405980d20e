#include "wall_for_test.hpp"

#include <cmath>
#include <cstddef>

namespace kinetrace::hal::test {
namespace {

// A number in [0, 1) for each grid point.
double noise(int x, int y) {
  auto h = static_cast<std::uint32_t>(x) * 0x9E3779B1U ^ static_cast<std::uint32_t>(y) * 0x85EBCA77U;
  h = (h ^ (h >> 15U)) * 0x2C1B3C6DU;
  h = (h ^ (h >> 12U)) * 0x297A2D39U;
  return static_cast<double>(h ^ (h >> 15U)) / 4294967296.0;
}

double texture(double x, double y) {
  constexpr double kCell = 9.0;
  const int x0 = static_cast<int>(std::floor(x / kCell));
  const int y0 = static_cast<int>(std::floor(y / kCell));
  const double ax = x / kCell - x0;
  const double ay = y / kCell - y0;
  return (noise(x0, y0) * (1 - ax) + noise(x0 + 1, y0) * ax) * (1 - ay) +
         (noise(x0, y0 + 1) * (1 - ax) + noise(x0 + 1, y0 + 1) * ax) * ay;
}

}  // namespace

std::vector<std::uint8_t> wall(int width, int height, double right_px, double down_px) {
  std::vector<std::uint8_t> pixels;
  pixels.reserve(static_cast<std::size_t>(width) * static_cast<std::size_t>(height));
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      pixels.push_back(static_cast<std::uint8_t>(20 + 210 * texture(x + right_px, y + down_px)));
    }
  }
  return pixels;
}

}  // namespace kinetrace::hal::test
