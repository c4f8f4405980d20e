// Clips lines and splits them into dashes.
#pragma once

#include <span>
#include <vector>

#include "canvas.hpp"

namespace kinetrace::drawing {

struct Segment {
  Point a;
  Point b;
};

/// Appends the drawn pieces of a line within `clip`. Points that are not finite interrupt the line. The phase of the
/// pattern follows the whole line, independent of the clip.
void append_dashes(std::span<const Point> points, const Rect& clip, Dash dash, double width_px,
                   std::vector<Segment>& segments);

}  // namespace kinetrace::drawing
