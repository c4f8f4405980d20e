#include <algorithm>
#include <cmath>

#include "drawing/plot.hpp"
#include "study/study_summary.hpp"

namespace kinetrace::app {
namespace {

using drawing::Point;

constexpr int kWidth_px = 1600;
constexpr int kHeight_px = 900;
constexpr double kTitle_px = 48.0;
constexpr double kGap_px = 12.0;

std::vector<std::size_t> shown_metrics() {
  std::vector<std::size_t> shown;
  for (std::size_t m = 0; m < kStudyMetrics.size(); ++m) {
    if (kStudyMetrics[m].in_plot) {
      shown.push_back(m);
    }
  }
  return shown;
}

/// RMS over all recordings, with a band from the best to the worst recording.
drawing::Series curve(const std::vector<StudyRun>& runs, const std::string& window, const StudyAxis& axis,
                      std::size_t metric, int style) {
  drawing::Series series;
  series.name = window == "default" ? "default configuration" : window + (window == "1" ? " frame" : " frames");
  series.style = drawing::line_style(style);
  const std::vector<std::string> recordings = recordings_of(runs);
  for (std::size_t i = 0; i + 1 < axis.edges.size(); ++i) {
    const StudyBin all = study_bin(runs, window, "", axis, i);
    const std::optional<double> rmse = all.shown(metric);
    const std::optional<double> place = all.axis.mean();
    if (!rmse || !place) {
      continue;
    }
    drawing::Range band{*rmse, *rmse};
    for (const std::string& recording : recordings) {
      if (const std::optional<double> one = study_bin(runs, window, recording, axis, i).errors[metric].rmse()) {
        band = {std::min(band.low, *one), std::max(band.high, *one)};
      }
    }
    series.points.emplace_back(*place, *rmse);
    series.band.push_back(band);
  }
  return series;
}

}  // namespace

Status write_study_plot(const std::vector<StudyRun>& runs, const std::filesystem::path& directory) {
  drawing::Canvas canvas(kWidth_px, kHeight_px, drawing::kPaper);
  canvas.text({kGap_px, kTitle_px * 0.65},
              "Error of an object's reconstruction by the frames it is made from; bands: best and worst recording",
              {.size_px = 14.0, .bold = true});
  const std::vector<std::size_t> shown = shown_metrics();
  const double width = (kWidth_px - kGap_px) / static_cast<double>(shown.size());
  const double height = (kHeight_px - kTitle_px) / static_cast<double>(study_axes().size());
  const std::vector<std::string> windows = windows_of(runs);
  for (std::size_t row = 0; row < study_axes().size(); ++row) {
    const StudyAxis& axis = study_axes()[row];
    for (std::size_t column = 0; column < shown.size(); ++column) {
      const StudyMetric& metric = kStudyMetrics[shown[column]];
      drawing::Plot plot;
      plot.title = metric.title;
      plot.x.label = axis.name == "distance_m" ? "distance [m]" : "height in the image [px]";
      plot.x.logarithmic = true;
      plot.y.label = "RMS error [" + std::string(metric.unit) + "]";
      plot.y.logarithmic = true;
      for (std::size_t w = 0; w < windows.size(); ++w) {
        plot.series.push_back(curve(runs, windows[w], axis, shown[column], static_cast<int>(w)));
        if (row > 0 || column > 0) {
          plot.series.back().name.clear();  // One legend is enough.
        }
      }
      const drawing::Rect cell{kGap_px + width * static_cast<double>(column),
                               kTitle_px + height * static_cast<double>(row), width - kGap_px, height - kGap_px};
      draw_plot(canvas, cell, plot);
    }
  }
  return canvas.write_png(directory / "object_size.png");
}

}  // namespace kinetrace::app
