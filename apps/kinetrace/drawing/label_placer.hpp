// Places labels without overlap and within the edges.
#pragma once

#include <optional>
#include <span>
#include <vector>

#include "canvas.hpp"

namespace kinetrace::drawing {

/// Places labels greedily: the first gets the best place.
class LabelPlacer {
 public:
  explicit LabelPlacer(const Rect& area) : area_(area) {}

  /// Reserves a rectangle of this size around `anchor` with the least overlap with avoided lines, then the nearest;
  /// none if every place is taken.
  [[nodiscard]] std::optional<Rect> place(const Point& anchor, double width_px, double height_px, double gap_px);
  /// Reserves this place, shifted into the area by at most its own size, if it is free.
  [[nodiscard]] std::optional<Rect> place_at(const Rect& wanted);
  /// Blocks a rectangle for labels.
  void block(const Rect& rect) { taken_.push_back(rect); }
  /// Adds a line to avoid where possible.
  void avoid(std::span<const Point> line);

 private:
  [[nodiscard]] bool is_free(const Rect& rect) const;

  Rect area_;
  std::vector<Rect> taken_;
  std::vector<Point> avoided_;  ///< Samples of the lines, a few pixels apart.
};

}  // namespace kinetrace::drawing
