#include "plot.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

namespace kinetrace::drawing {
namespace {

constexpr double kTitleSize_px = 11.0;
constexpr double kTitleHeight_px = 30.0;
constexpr double kTextSize_px = 9.0;
constexpr double kLegendRow_px = 20.0;
constexpr double kLegendSample_px = 30.0;
constexpr double kPad_px = 10.0;

bool is_drawable(const PlotAxis& axis, double value) {
  return std::isfinite(value) && (!axis.logarithmic || value > 0.0);
}

// Extremes, rounded outwards.
Range rounded(const PlotAxis& axis, double low, double high) {
  if (axis.logarithmic) {
    const double bottom = round_below(low);
    const double top = round_above(high);
    return {bottom, top > bottom ? top : bottom * 10.0};
  }
  if (!(high > low)) {
    const double half = std::max(std::abs(low) * 0.1, 0.5);
    return {low - half, high + half};
  }
  // An axis that begins near zero starts at zero.
  if (low > 0.0 && low < 0.4 * high) {
    low = 0.0;
  }
  const double step = round_above((high - low) / 6.0);
  return {std::floor(low / step + 1e-9) * step, std::ceil(high / step - 1e-9) * step};
}

Range range_of(const PlotAxis& axis, const std::vector<double>& values) {
  double low = std::numeric_limits<double>::infinity();
  double high = -low;
  for (const double value : values) {
    if (is_drawable(axis, value)) {
      low = std::min(low, value);
      high = std::max(high, value);
    }
  }
  Range range = low <= high ? rounded(axis, low, high) : axis.logarithmic ? Range{0.1, 10.0} : Range{0.0, 1.0};
  range.low = axis.low.value_or(range.low);
  range.high = axis.high.value_or(range.high);
  if (!(range.high > range.low)) {
    range.high = axis.logarithmic ? range.low * 10.0 : range.low + 1.0;
  }
  return range;
}

Axes axes_of(const Plot& plot, const Rect& area) {
  std::vector<double> x;
  std::vector<double> y;
  for (const Series& series : plot.series) {
    for (const Point& p : series.points) {
      if (is_drawable(plot.x, p.x()) && is_drawable(plot.y, p.y())) {
        x.push_back(p.x());
        y.push_back(p.y());
      }
    }
    for (const Range& band : series.band) {
      y.push_back(band.low);
      y.push_back(band.high);
    }
  }
  return {area,
          {.label = plot.x.label, .range = range_of(plot.x, x), .logarithmic = plot.x.logarithmic},
          {.label = plot.y.label, .range = range_of(plot.y, y), .logarithmic = plot.y.logarithmic}};
}

void draw_band(Canvas& canvas, const Axes& axes, const Series& series) {
  if (series.band.size() != series.points.size()) {
    return;
  }
  for (std::size_t i = 1; i < series.band.size(); ++i) {
    const double x0 = series.points[i - 1].x();
    const double x1 = series.points[i].x();
    const std::array<Point, 4> corners{axes.to_canvas(x0, series.band[i - 1].low),
                                       axes.to_canvas(x1, series.band[i].low), axes.to_canvas(x1, series.band[i].high),
                                       axes.to_canvas(x0, series.band[i - 1].high)};
    canvas.polygon(corners, series.style.color, 0.14);
  }
}

void draw_series(Canvas& canvas, const std::vector<Point>& points, const Series& series) {
  if (series.line) {
    canvas.polyline(points, {.color = series.style.color, .width_px = 2.0, .dash = series.style.dash});
  }
  if (series.markers) {
    const double radius = series.line || points.size() < 200 ? 3.2 : 2.0;
    for (const Point& p : points) {
      canvas.disk(p, radius, series.style.color, series.line ? 1.0 : 0.75);
    }
  }
}

// The corner of the area in which a box of this size covers the fewest points.
Rect emptiest_corner(const Rect& area, double width, double height, const std::vector<Point>& points) {
  const double left = area.x + kPad_px;
  const double right = area.right() - kPad_px - width;
  const double top = area.y + kPad_px;
  const double bottom = area.bottom() - kPad_px - height;
  const std::array<Rect, 4> corners{{{right, top, width, height},
                                     {left, top, width, height},
                                     {right, bottom, width, height},
                                     {left, bottom, width, height}}};
  const auto covered = [&](const Rect& box) {
    return std::count_if(points.begin(), points.end(), [&](const Point& p) { return box.grown(6.0).contains(p); });
  };
  return *std::min_element(corners.begin(), corners.end(),
                           [&](const Rect& a, const Rect& b) { return covered(a) < covered(b); });
}

void draw_legend(Canvas& canvas, const Axes& axes, const Plot& plot, const std::vector<Point>& points) {
  const TextStyle style{.size_px = kTextSize_px, .vertical = VerticalAnchor::kMiddle};
  double width = 0.0;
  int rows = 0;
  for (const Series& series : plot.series) {
    if (!series.name.empty()) {
      width = std::max(width, text_width(series.name, style));
      ++rows;
    }
  }
  if (rows == 0) {
    return;
  }
  const Rect box =
      emptiest_corner(axes.area(), width + kLegendSample_px + 3 * kPad_px, rows * kLegendRow_px + kPad_px, points);
  canvas.rectangle(box, kPaper, 0.85);
  canvas.outline(box, {.color = kGrid, .width_px = 1.0});
  double y = box.y + kPad_px / 2 + kLegendRow_px / 2;
  for (const Series& series : plot.series) {
    if (series.name.empty()) {
      continue;
    }
    const double x = box.x + kPad_px;
    const std::vector<Point> sample{{x, y}, {x + kLegendSample_px, y}};
    Series shown = series;
    shown.markers = false;
    draw_series(canvas, sample, shown);
    if (series.markers) {
      canvas.disk({x + kLegendSample_px / 2, y}, 3.2, series.style.color);
    }
    canvas.text({x + kLegendSample_px + kPad_px, y}, series.name, style);
    y += kLegendRow_px;
  }
}

// The corners of all lines and, so that a legend avoids them, points between.
std::vector<Point> along(const std::vector<Point>& line) {
  std::vector<Point> points(line);
  for (std::size_t i = 1; i < line.size(); ++i) {
    for (const double share : {0.2, 0.4, 0.6, 0.8}) {
      points.push_back(line[i - 1] + (line[i] - line[i - 1]) * share);
    }
  }
  return points;
}

}  // namespace

void draw_plot(Canvas& canvas, const Rect& rect, const Plot& plot) {
  canvas.text({rect.x + kMarginLeft_px, rect.y + kTitleSize_px + 4.0},
              shortened(plot.title, rect.width - kMarginLeft_px, {.size_px = kTitleSize_px, .bold = true}),
              {.size_px = kTitleSize_px, .bold = true});
  const Rect area =
      inside_margins({rect.x, rect.y + kTitleHeight_px, rect.width - kPad_px, rect.height - kTitleHeight_px});
  const Axes axes = axes_of(plot, area);
  axes.draw(canvas);
  canvas.clip(area);
  std::vector<Point> drawn;
  for (const Series& series : plot.series) {
    draw_band(canvas, axes, series);
  }
  for (const Series& series : plot.series) {
    std::vector<Point> points;
    for (const Point& p : series.points) {
      points.push_back(axes.to_canvas(p.x(), p.y()));
    }
    draw_series(canvas, points, series);
    const std::vector<Point> covered = series.line ? along(points) : points;
    std::copy_if(covered.begin(), covered.end(), std::back_inserter(drawn),
                 [](const Point& p) { return p.allFinite(); });
  }
  canvas.unclip();
  if (drawn.empty()) {
    canvas.text(area.center(), "no data",
                {.size_px = kTitleSize_px, .color = kMuted, .horizontal = HorizontalAnchor::kCenter});
  }
  draw_legend(canvas, axes, plot, drawn);
}

}  // namespace kinetrace::drawing
