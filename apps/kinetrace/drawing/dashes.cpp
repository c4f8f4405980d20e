#include "dashes.hpp"

#include <algorithm>
#include <cmath>
#include <optional>

namespace kinetrace::drawing {
namespace {

struct Pattern {
  double ink_px = 0.0;
  double period_px = 0.0;  ///< 0: solid.
};

Pattern pattern_of(Dash dash, double width_px) {
  const double unit = std::max(width_px, 1.0);
  switch (dash) {
    case Dash::kSolid: return {};
    case Dash::kDashed: return {4.0 * unit, 7.0 * unit};
    case Dash::kDotted: return {0.3 * unit, 2.2 * unit};
  }
  return {};
}

/// Shares [begin, end] of a segment.
struct Interval {
  double begin = 0.0;
  double end = 1.0;
};

// Liang and Barsky, "A new concept and method for line clipping", 1984.
std::optional<Interval> visible_part(const Point& a, const Point& b, const Rect& clip) {
  Interval part;
  const Point d = b - a;
  const double low[2] = {clip.x, clip.y};
  const double high[2] = {clip.right(), clip.bottom()};
  for (int axis = 0; axis < 2; ++axis) {
    if (d[axis] == 0.0) {
      if (a[axis] < low[axis] || a[axis] > high[axis]) {
        return std::nullopt;
      }
      continue;
    }
    const double to_low = (low[axis] - a[axis]) / d[axis];
    const double to_high = (high[axis] - a[axis]) / d[axis];
    part.begin = std::max(part.begin, std::min(to_low, to_high));
    part.end = std::min(part.end, std::max(to_low, to_high));
  }
  if (part.begin > part.end) {
    return std::nullopt;
  }
  return part;
}

void append_pattern(const Point& a, const Point& b, const Interval& part, double length, double travelled,
                    const Pattern& pattern, std::vector<Segment>& segments) {
  const double end = part.end * length;
  double at = part.begin * length;
  while (at < end) {
    const double phase = std::fmod(travelled + at, pattern.period_px);
    const bool inked = phase < pattern.ink_px;
    // A step of at least this much always makes progress.
    constexpr double kMin_px = 1e-6;
    const double next = std::min(end, at + std::max((inked ? pattern.ink_px : pattern.period_px) - phase, kMin_px));
    if (inked) {
      segments.push_back({a + (b - a) * (at / length), a + (b - a) * (next / length)});
    }
    at = next;
  }
}

}  // namespace

void append_dashes(std::span<const Point> points, const Rect& clip, Dash dash, double width_px,
                   std::vector<Segment>& segments) {
  const Pattern pattern = pattern_of(dash, width_px);
  double travelled = 0.0;
  for (std::size_t i = 1; i < points.size(); ++i) {
    const Point& a = points[i - 1];
    const Point& b = points[i];
    if (!a.allFinite() || !b.allFinite()) {
      continue;
    }
    const double length = (b - a).norm();
    if (const auto part = visible_part(a, b, clip)) {
      if (pattern.period_px == 0.0 || length == 0.0) {
        segments.push_back({a + (b - a) * part->begin, a + (b - a) * part->end});
      } else {
        append_pattern(a, b, *part, length, travelled, pattern, segments);
      }
    }
    travelled = std::fmod(travelled + length, pattern.period_px == 0.0 ? 1.0 : pattern.period_px);
  }
}

}  // namespace kinetrace::drawing
