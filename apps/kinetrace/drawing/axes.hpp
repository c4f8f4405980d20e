// Axes: map values to pixels, with ticks at round numbers.
#pragma once

#include <optional>
#include <span>
#include <string>
#include <vector>

#include "canvas.hpp"

namespace kinetrace::drawing {

/// Values from `low` to `high`, low < high.
struct Range {
  double low = 0.0;
  double high = 1.0;

  [[nodiscard]] double size() const noexcept { return high - low; }
  [[nodiscard]] double center() const noexcept { return (low + high) / 2; }
  /// Widened by a share of its size at both ends.
  [[nodiscard]] Range widened(double share) const noexcept { return {low - share * size(), high + share * size()}; }
  /// Widened about its centre to at least this size.
  [[nodiscard]] Range at_least(double least) const noexcept {
    return size() >= least ? *this : Range{center() - least / 2, center() + least / 2};
  }
};

/// From the quantile `share` to the quantile 1 - `share` of the finite values, robust to outliers. None without a
/// finite value. Reorders `values`.
[[nodiscard]] std::optional<Range> quantile_range(std::vector<double>& values, double share);

struct Tick {
  double value = 0.0;
  std::string label;  ///< Empty: a line without a number.
};

/// Multiples of 1, 2 or 5 times a power of ten within the range, at most `most` + 1 of them.
[[nodiscard]] std::vector<Tick> linear_ticks(const Range& range, int most);
/// Powers of ten with numbers, and their multiples without; with few decades some of the multiples have numbers.
/// `range` is positive.
[[nodiscard]] std::vector<Tick> log_ticks(const Range& range);
/// The largest of 1, 2, 5 times a power of ten that is not above `limit` > 0.
[[nodiscard]] double round_below(double limit);
/// The smallest of them that is not below `limit` > 0.
[[nodiscard]] double round_above(double limit);
/// A number for a label: the fewest digits that distinguish values `step` apart.
[[nodiscard]] std::string tick_label(double value, double step);

/// One axis of a drawing.
struct Axis {
  std::string label;  ///< With its unit: "z forward [m]".
  Range range;
  bool logarithmic = false;
  bool reversed = false;  ///< Values grow to the left, or downwards.
};

/// A plot area with two axes.
class Axes {
 public:
  /// `area` excludes numbers and labels, which take the margins below.
  Axes(const Rect& area, Axis x, Axis y);

  /// Position of a point on the canvas; not finite if the value is not finite, or not positive on a logarithmic axis.
  [[nodiscard]] Point to_canvas(double x, double y) const;
  [[nodiscard]] const Rect& area() const noexcept { return area_; }

  /// Background, thin grid, numbers and labels. Clip later drawing to `area`.
  void draw(Canvas& canvas) const;

 private:
  void draw_ticks_x(Canvas& canvas) const;
  void draw_ticks_y(Canvas& canvas) const;

  Rect area_;
  Axis x_;
  Axis y_;
};

/// Space for numbers and labels outside the area.
inline constexpr double kMarginLeft_px = 68.0;
inline constexpr double kMarginBelow_px = 44.0;

/// The part of `rect` that remains inside these margins.
[[nodiscard]] Rect inside_margins(const Rect& rect);

}  // namespace kinetrace::drawing
