#include "kinetrace/tracking/reference_mask.hpp"

#include <algorithm>
#include <array>
#include <cmath>

namespace kinetrace::tracking {

ReferenceMask::ReferenceMask(Arena& arena, int width, int height)
    : width_(width), height_(height), row_bytes_((width + 7) / 8) {
  bits_ = arena.take<std::uint8_t>(static_cast<std::size_t>(row_bytes_) * static_cast<std::size_t>(height));
}

void ReferenceMask::current_corners(Eigen::Vector2d& low, Eigen::Vector2d& high) const noexcept {
  low = {1e9, 1e9};
  high = {-1e9, -1e9};
  for (const double x : {box_.x0 - 0.5, box_.x1 - 0.5}) {
    for (const double y : {box_.y0 - 0.5, box_.y1 - 0.5}) {
      const Eigen::Vector2d corner = now_from_ref_ * Eigen::Vector2d(x, y);
      low = low.cwiseMin(corner);
      high = high.cwiseMax(corner);
    }
  }
}

double ReferenceMask::part_in_image() const noexcept {
  Eigen::Vector2d low;
  Eigen::Vector2d high;
  current_corners(low, high);
  const Eigen::Vector2d size(width_, height_);
  const Eigen::Vector2d inside = high.cwiseMin(size) - low.cwiseMax(0.0);
  const Eigen::Vector2d whole = high - low;
  return box_.empty() || inside.minCoeff() <= 0.0 ? 0.0 : inside.prod() / whole.prod();
}

PixelBox ReferenceMask::current_box() const noexcept {
  if (box_.empty()) {
    return {};
  }
  Eigen::Vector2d low;
  Eigen::Vector2d high;
  current_corners(low, high);
  // Clamping before the conversion keeps far-away boxes representable.
  const auto pixel = [](double value, int size) {
    return static_cast<int>(std::clamp(value, 0.0, static_cast<double>(size)));
  };
  const PixelBox box{pixel(std::floor(low.x()), width_), pixel(std::floor(low.y()), height_),
                     pixel(std::ceil(high.x()) + 1.0, width_), pixel(std::ceil(high.y()) + 1.0, height_)};
  return box.empty() ? PixelBox{} : box;
}

double ReferenceMask::current_reach_px() const noexcept {
  return 0.5 * std::hypot(box_.width(), box_.height()) * now_from_ref_.scale();
}

Eigen::Vector2d ReferenceMask::current_center() const noexcept {
  return now_from_ref_ * Eigen::Vector2d(box_.center_x(), box_.center_y());
}

}  // namespace kinetrace::tracking
