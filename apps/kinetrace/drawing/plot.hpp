// Curves and points over two axes, with a legend: for tables of measurements.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "axes.hpp"
#include "canvas.hpp"

namespace kinetrace::drawing {

struct PlotAxis {
  std::string label;  ///< With its unit: "distance [m]".
  bool logarithmic = false;
  std::optional<double> low = {};  ///< Default: from the data, rounded outwards.
  std::optional<double> high = {};
};

/// One curve. Points that are not finite, or not positive on a logarithmic axis, interrupt it.
struct Series {
  std::string name = {};
  std::vector<Point> points = {};
  LineStyle style = {};
  bool line = true;
  bool markers = true;
  /// Lower and upper end of a shaded band at each point, for example quartiles; empty, or as long as `points`.
  std::vector<Range> band = {};
};

struct Plot {
  std::string title = {};
  PlotAxis x = {};
  PlotAxis y = {};
  std::vector<Series> series = {};
};

/// Draws into `rect`, title and labels included; at least 240 x 180 pixels. The legend goes to the corner with the
/// fewest points; series without a name have no entry. A plot without points contains a note instead.
void draw_plot(Canvas& canvas, const Rect& rect, const Plot& plot);

}  // namespace kinetrace::drawing
