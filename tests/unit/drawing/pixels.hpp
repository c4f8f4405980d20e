// Helpers to examine drawn pixels.
#pragma once

#include <cstdlib>

#include "drawing/canvas.hpp"

namespace kinetrace::imaging {

// In the namespace of the type, for argument-dependent lookup.
inline bool operator==(const Rgb8& a, const Rgb8& b) {
  return a.r == b.r && a.g == b.g && a.b == b.b;
}

}  // namespace kinetrace::imaging

namespace kinetrace::drawing {

/// Within a few levels in every channel.
inline bool is_near(const Color& a, const Color& b, int levels = 3) {
  return std::abs(a.r - b.r) <= levels && std::abs(a.g - b.g) <= levels && std::abs(a.b - b.b) <= levels;
}

/// Pixels of this colour within a rectangle of the canvas.
inline int count_near(const Canvas& canvas, const Rect& rect, const Color& color, int levels = 3) {
  int count = 0;
  for (int y = static_cast<int>(rect.y); y < static_cast<int>(rect.bottom()); ++y) {
    for (int x = static_cast<int>(rect.x); x < static_cast<int>(rect.right()); ++x) {
      count += is_near(canvas.at(x, y), color, levels) ? 1 : 0;
    }
  }
  return count;
}

inline int count_near(const Canvas& canvas, const Color& color, int levels = 3) {
  return count_near(canvas, {0, 0, static_cast<double>(canvas.width()), static_cast<double>(canvas.height())}, color,
                    levels);
}

}  // namespace kinetrace::drawing
