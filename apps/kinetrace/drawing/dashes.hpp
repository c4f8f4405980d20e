// Lines cut to what is visible, and into dashes.
#pragma once

#include <span>
#include <vector>

#include "canvas.hpp"

namespace kinetrace::drawing {

struct Segment {
  Point a;
  Point b;
};

/// Appends the pieces of a line that lie within `clip` and are inked. Points that are not finite interrupt the line.
/// The pattern follows the length of the whole line, whatever of it is visible.
void append_dashes(std::span<const Point> points, const Rect& clip, Dash dash, double width_px,
                   std::vector<Segment>& segments);

}  // namespace kinetrace::drawing
