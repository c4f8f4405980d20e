// Names on coloured ground beside what they name.
#pragma once

#include <string>
#include <vector>

#include "canvas.hpp"

namespace kinetrace::drawing {

/// Something to be named.
struct Chip {
  std::vector<std::string> texts;  ///< The best first, then shorter ones for where that does not fit; at least one.
  Color color;
  Rect target;  ///< What is named; the chip goes above it, else below, else beside.
};

/// More chips than this make a crowd, in which none has the best of its texts.
inline constexpr std::size_t kCrowd = 16;

/// Draws chips that neither overlap nor leave `area`, those of tall targets first; what finds no place is left out.
void draw_chips(Canvas& canvas, const Rect& area, std::vector<Chip> chips, double size_px);

}  // namespace kinetrace::drawing
