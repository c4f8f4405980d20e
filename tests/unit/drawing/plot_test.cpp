#include "drawing/plot.hpp"

#include <limits>

#include "pixels.hpp"

namespace kinetrace::drawing {
namespace {

constexpr Rect kWhole{10, 10, 580, 380};

Plot two_curves() {
  Plot plot{.title = "Errors", .x = {.label = "height [px]", .logarithmic = true}, .y = {.label = "error [m]"}};
  for (int i = 0; i < 2; ++i) {
    Series series{.name = "series " + std::to_string(i), .points = {}, .style = line_style(i)};
    for (const double x : {10.0, 20.0, 40.0, 80.0}) {
      series.points.emplace_back(x, (1 + i) / x);
    }
    plot.series.push_back(series);
  }
  return plot;
}

TEST(Plot, ShowsEverySeriesInItsColour) {
  Canvas canvas(600, 400, kPaper);
  draw_plot(canvas, kWhole, two_curves());
  EXPECT_GT(count_near(canvas, line_style(0).color), 100);
  EXPECT_GT(count_near(canvas, line_style(1).color), 100);
}

TEST(Plot, StaysWithinItsRectangle) {
  Canvas canvas(600, 400, kPaper);
  Plot plot = two_curves();
  plot.title = "A title that is far longer than the plot is wide, so that it has to be cut somewhere before the edge";
  draw_plot(canvas, {50, 50, 300, 250}, plot);
  EXPECT_EQ(count_near(canvas, {0, 0, 600, 48}, kPaper, 0), 600 * 48);
  EXPECT_EQ(count_near(canvas, {354, 0, 246, 400}, kPaper, 0), 246 * 400);
  EXPECT_EQ(count_near(canvas, {0, 304, 600, 96}, kPaper, 0), 600 * 96);
}

TEST(Plot, IgnoresValuesThatCannotBeDrawn) {
  Canvas canvas(600, 400, kPaper);
  Plot plot = two_curves();
  plot.series[0].points.emplace_back(0.0, 1.0);  // No logarithm.
  plot.series[0].points.emplace_back(-5.0, 1e9);
  plot.series[0].points.emplace_back(30.0, std::numeric_limits<double>::infinity());
  Canvas expected(600, 400, kPaper);
  draw_plot(expected, kWhole, two_curves());
  draw_plot(canvas, kWhole, plot);
  // The scale has not changed: the other series lies where it was.
  EXPECT_EQ(count_near(canvas, line_style(1).color, 0), count_near(expected, line_style(1).color, 0));
}

TEST(Plot, WithoutDataSaysSo) {
  Canvas canvas(600, 400, kPaper);
  draw_plot(canvas, kWhole, {.title = "Empty", .x = {.label = "x"}, .y = {.label = "y", .logarithmic = true}});
  EXPECT_GT(count_near(canvas, {250, 180, 200, 60}, kMuted, 60), 20);
}

TEST(Plot, DrawsASinglePointAndEqualValues) {
  Canvas canvas(600, 400, kPaper);
  Plot plot{.title = "", .x = {.label = "x"}, .y = {.label = "y"}};
  plot.series.push_back({.name = "", .points = {{3.0, 5.0}}, .style = line_style(2)});
  draw_plot(canvas, kWhole, plot);
  EXPECT_GT(count_near(canvas, line_style(2).color), 15);
}

TEST(Plot, BandsShadeBetweenTheirLimits) {
  Canvas canvas(600, 400, kPaper);
  Plot plot{.title = "", .x = {.label = "x"}, .y = {.label = "y", .low = 0.0, .high = 10.0}};
  plot.series.push_back(
      {.name = "", .points = {{0.0, 5.0}, {10.0, 5.0}}, .style = line_style(0), .band = {{2.0, 8.0}, {2.0, 8.0}}});
  draw_plot(canvas, kWhole, plot);
  const Color shaded = mix(kPanel, line_style(0).color, 0.14);
  const int pixels = count_near(canvas, shaded, 3);
  EXPECT_GT(pixels, 60'000);
  EXPECT_LT(pixels, 110'000);
}

TEST(Plot, LegendAvoidsTheCurves) {
  // Data in the upper right corner: the legend moves away.
  Plot plot{.title = "", .x = {.label = "x", .low = 0.0, .high = 10.0}, .y = {.label = "y", .low = 0.0, .high = 10.0}};
  Series series{.name = "curve", .points = {}, .style = line_style(0)};
  for (int i = 0; i < 20; ++i) {
    series.points.emplace_back(8.0 + 0.1 * i, 9.0 + 0.05 * i);
  }
  plot.series.push_back(series);
  Canvas canvas(600, 400, kPaper);
  draw_plot(canvas, kWhole, plot);
  const int samples = count_near(canvas, {80, 40, 150, 60}, line_style(0).color) +
                      count_near(canvas, {80, 250, 150, 90}, line_style(0).color) +
                      count_near(canvas, {430, 250, 150, 90}, line_style(0).color);
  EXPECT_GT(samples, 20);
}

}  // namespace
}  // namespace kinetrace::drawing
