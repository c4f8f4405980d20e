// Pictures of a textured wall and a textured board that moves before it, with exact disparities: input of the dense
// part of motion segmentation.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "kinetrace/core/frame.hpp"
#include "kinetrace/core/stereo_geometry.hpp"

namespace kinetrace::test {

/// A rectangle of the image, pixels; half open.
struct Board {
  double x0 = 0.0;
  double y0 = 0.0;
  double width = 0.0;
  double height = 0.0;
  double disparity_px = 0.0;
  // Its columns without texture, from its left side.
  double plain_x0 = 0.0;
  double plain_x1 = 0.0;
};

/// Texture of a surface at (x, y): grey values that are smooth over a few pixels and never repeat.
[[nodiscard]] inline double texture(double x, double y, std::uint32_t surface) {
  const auto lattice = [surface](int i, int j) {
    std::uint32_t h =
        static_cast<std::uint32_t>(i) * 374761393U + static_cast<std::uint32_t>(j) * 668265263U + surface * 2246822519U;
    h = (h ^ (h >> 13U)) * 1274126177U;
    return static_cast<double>((h ^ (h >> 16U)) & 255U);
  };
  constexpr double kCellPx = 5.0;
  const double u = x / kCellPx;
  const double v = y / kCellPx;
  const int i = static_cast<int>(std::floor(u));
  const int j = static_cast<int>(std::floor(v));
  const double a = u - i;
  const double b = v - j;
  return (1 - b) * ((1 - a) * lattice(i, j) + a * lattice(i + 1, j)) +
         b * ((1 - a) * lattice(i, j + 1) + a * lattice(i + 1, j + 1));
}

class MovingPicture {
 public:
  MovingPicture(const StereoGeometry& geometry, double wall_disparity_px)
      : geometry_(geometry),
        wall_disparity_px_(wall_disparity_px),
        left_(static_cast<std::size_t>(geometry.width_px) * static_cast<std::size_t>(geometry.height_px)),
        right_(left_.size()) {}

  /// Draws both views. The wall has texture 1, the board texture 2 in its own axes, or one grey value where `plain`.
  void draw(const Board& board, bool plain = false) {
    for (int y = 0; y < geometry_.height_px; ++y) {
      for (int x = 0; x < geometry_.width_px; ++x) {
        left_[index(x, y)] = grey(x, y, 0.0, board, plain);
        right_[index(x, y)] = grey(x, y, 1.0, board, plain);
      }
    }
  }
  [[nodiscard]] RectifiedPair pair(std::int64_t frame, std::int64_t timestamp_ns) const {
    RectifiedPair out;
    out.frame_index = frame;
    out.timestamp_ns = timestamp_ns;
    out.geometry = geometry_;
    out.left = {left_.data(), geometry_.width_px, geometry_.height_px, geometry_.width_px};
    out.right = {right_.data(), geometry_.width_px, geometry_.height_px, geometry_.width_px};
    return out;
  }

 private:
  [[nodiscard]] std::size_t index(int x, int y) const {
    return static_cast<std::size_t>(y) * static_cast<std::size_t>(geometry_.width_px) + static_cast<std::size_t>(x);
  }
  /// `right` 1 in the right view, 0 in the left one.
  [[nodiscard]] std::uint8_t grey(int x, int y, double right, const Board& board, bool plain) const {
    const double u = x + right * board.disparity_px - board.x0;
    const double v = y - board.y0;
    const bool on_board = u >= 0.0 && v >= 0.0 && u < board.width && v < board.height;
    if (on_board && (plain || (u >= board.plain_x0 && u < board.plain_x1))) {
      return 90;
    }
    const double value = on_board ? texture(u, v, 2) : texture(x + right * wall_disparity_px_, y, 1);
    return static_cast<std::uint8_t>(std::clamp(20.0 + 0.8 * value, 0.0, 255.0));
  }

  StereoGeometry geometry_;
  double wall_disparity_px_;
  std::vector<std::uint8_t> left_;
  std::vector<std::uint8_t> right_;
};

}  // namespace kinetrace::test
