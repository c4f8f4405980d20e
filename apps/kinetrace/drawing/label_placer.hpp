// Labels that cover neither each other nor the edge.
#pragma once

#include <optional>
#include <span>
#include <vector>

#include "canvas.hpp"

namespace kinetrace::drawing {

/// Finds room for labels one after the other: the first come is the best placed.
class LabelPlacer {
 public:
  explicit LabelPlacer(const Rect& area) : area_(area) {}

  /// Takes a rectangle of this size beside or above `anchor`, where it covers the least of what it should avoid, and as
  /// near as possible; none if every place is taken.
  [[nodiscard]] std::optional<Rect> place(const Point& anchor, double width_px, double height_px, double gap_px);
  /// Takes exactly this place, if it is free and within the area, when moved into the area by at most its own size.
  [[nodiscard]] std::optional<Rect> place_at(const Rect& wanted);
  /// No label will lie here.
  void block(const Rect& rect) { taken_.push_back(rect); }
  /// Labels avoid this line where they can.
  void avoid(std::span<const Point> line);

 private:
  [[nodiscard]] bool is_free(const Rect& rect) const;

  Rect area_;
  std::vector<Rect> taken_;
  std::vector<Point> avoided_;  ///< A few pixels apart.
};

}  // namespace kinetrace::drawing
