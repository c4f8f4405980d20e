#include "label_placer.hpp"

#include <algorithm>
#include <array>

namespace kinetrace::drawing {

bool LabelPlacer::is_free(const Rect& rect) const {
  return rect.x >= area_.x && rect.y >= area_.y && rect.right() <= area_.right() && rect.bottom() <= area_.bottom() &&
         std::none_of(taken_.begin(), taken_.end(), [&](const Rect& other) { return rect.overlaps(other); });
}

std::optional<Rect> LabelPlacer::place_at(const Rect& wanted) {
  Rect rect = wanted;
  rect.x = std::clamp(rect.x, area_.x, std::max(area_.x, area_.right() - rect.width));
  rect.y = std::clamp(rect.y, area_.y, std::max(area_.y, area_.bottom() - rect.height));
  if (!rect.grown(std::max(rect.width, rect.height)).overlaps(wanted) || !is_free(rect)) {
    return std::nullopt;
  }
  taken_.push_back(rect);
  return rect;
}

std::optional<Rect> LabelPlacer::place(const Point& anchor, double width_px, double height_px, double gap_px) {
  if (!anchor.allFinite()) {
    return std::nullopt;
  }
  // Directions from the anchor to the label's centre: right, above, left, below, then the corners; then farther out.
  constexpr std::array<std::array<double, 2>, 8> kDirections{
      {{1, 0}, {0, -1}, {-1, 0}, {0, 1}, {1, -1}, {1, 1}, {-1, -1}, {-1, 1}}};
  std::optional<Rect> best;
  std::ptrdiff_t least = 0;
  for (const double distance : {1.0, 2.2, 4.0}) {
    for (const auto& [dx, dy] : kDirections) {
      const Point center =
          anchor + Point(dx * (width_px / 2 + gap_px * distance), dy * (height_px / 2 + gap_px * distance));
      const Rect rect{center.x() - width_px / 2, center.y() - height_px / 2, width_px, height_px};
      if (!is_free(rect)) {
        continue;
      }
      const std::ptrdiff_t covered =
          std::count_if(avoided_.begin(), avoided_.end(), [&](const Point& p) { return rect.contains(p); });
      if (!best || covered < least) {
        best = rect;
        least = covered;
      }
    }
  }
  if (best) {
    taken_.push_back(*best);
  }
  return best;
}

void LabelPlacer::avoid(std::span<const Point> line) {
  constexpr double kStep_px = 4.0;
  for (std::size_t i = 0; i < line.size(); ++i) {
    if (!area_.contains(line[i])) {
      continue;
    }
    avoided_.push_back(line[i]);
    if (i == 0 || !area_.contains(line[i - 1])) {
      continue;
    }
    const double length = (line[i] - line[i - 1]).norm();
    for (int step = 1; step * kStep_px < length; ++step) {
      avoided_.push_back(line[i - 1] + (line[i] - line[i - 1]) * (step * kStep_px / length));
    }
  }
}

}  // namespace kinetrace::drawing
