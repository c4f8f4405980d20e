// Chips: names on coloured ground beside their targets.
#pragma once

#include <string>
#include <vector>

#include "canvas.hpp"

namespace kinetrace::drawing {

/// A name and its target.
struct Chip {
  std::vector<std::string> texts;  ///< At least one, in order of preference: shorter ones are used if space is short.
  Color color;
  Rect target;  ///< The chip goes above the target, else below, else beside.
};

/// With more chips than this, none uses its first text.
inline constexpr std::size_t kCrowd = 16;

/// Draws chips that neither overlap nor leave `area`, those of tall targets first; chips without room are left out.
void draw_chips(Canvas& canvas, const Rect& area, std::vector<Chip> chips, double size_px);

}  // namespace kinetrace::drawing
