#include "alignment.hpp"

#include <cmath>

namespace kinetrace::simulator {
namespace {

// Bilinear; the position must have a neighbour on each side.
template <typename T>
double sample(const Image<T>& image, double u, double v) {
  const int x = static_cast<int>(std::floor(u));
  const int y = static_cast<int>(std::floor(v));
  const double a = u - x;
  const double b = v - y;
  return (1 - b) * ((1 - a) * image.at(x, y) + a * image.at(x + 1, y)) +
         b * ((1 - a) * image.at(x, y + 1) + a * image.at(x + 1, y + 1));
}

bool inside(const Image<float>& image, double u, double v) {
  return u >= 2.0 && v >= 2.0 && u < image.width() - 3.0 && v < image.height() - 3.0;
}

// Whether the pixel and its neighbours are on one smooth surface.
bool smooth_around(const Image<float>& depth_m, int x, int y) {
  const float middle = depth_m.at(x, y);
  if (middle <= 0.F) {
    return false;
  }
  for (int dy = -1; dy <= 1; ++dy) {
    for (int dx = -1; dx <= 1; ++dx) {
      const float other = depth_m.at(x + dx, y + dy);
      if (other <= 0.F || std::abs(1.F / other - 1.F / middle) > 0.02F / middle) {
        return false;
      }
    }
  }
  return true;
}

}  // namespace

Alignment align(const Side& source, const Side& target, const Warp& warp) {
  Alignment result;
  int landed = 0;
  Eigen::Matrix2d normal = Eigen::Matrix2d::Zero();
  Eigen::Vector2d right_side = Eigen::Vector2d::Zero();
  for (int y = 2; y < source.picture.height() - 2; ++y) {
    for (int x = 2; x < source.picture.width() - 2; ++x) {
      if (!smooth_around(source.depth_m, x, y)) {
        continue;
      }
      const std::optional<Eigen::Vector3d> at = warp(x, y, static_cast<double>(source.depth_m.at(x, y)));
      if (!at || !inside(target.depth_m, at->x(), at->y())) {
        continue;
      }
      ++landed;
      const int u = static_cast<int>(std::lround(at->x()));
      const int v = static_cast<int>(std::lround(at->y()));
      if (!smooth_around(target.depth_m, u, v) ||
          std::abs(sample(target.depth_m, at->x(), at->y()) - at->z()) > 0.004 * at->z()) {
        continue;
      }
      ++result.count;
      const auto level = [&](double du, double dv) { return sample(target.picture, at->x() + du, at->y() + dv); };
      const double error = level(0, 0) - source.picture.at(x, y);
      result.mean_abs_levels += std::abs(error);
      // Lucas and Kanade, "An iterative image registration technique", 1981: one step for the whole picture.
      const Eigen::Vector2d gradient(0.5 * (level(1, 0) - level(-1, 0)), 0.5 * (level(0, 1) - level(0, -1)));
      if (std::abs(error) < 25.0) {
        normal += gradient * gradient.transpose();
        right_side -= gradient * error;
      }
    }
  }
  result.expected_share = landed > 0 ? static_cast<double>(result.count) / landed : 0.0;
  result.mean_abs_levels /= std::max(result.count, 1);
  result.offset_px = normal.ldlt().solve(right_side);
  return result;
}

}  // namespace kinetrace::simulator
