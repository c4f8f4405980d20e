#include "study/limit_summary.hpp"

#include <algorithm>
#include <cstdio>
#include <numeric>
#include <sstream>

#include "drawing/plot.hpp"
#include "kinetrace/core/config_check.hpp"
#include "kinetrace/core/files.hpp"
#include "kinetrace/imaging/image_info.hpp"

namespace kinetrace::app {
namespace {

namespace fs = std::filesystem;

// The table begins with this, by which that of an earlier study is recognised.
constexpr const char* kTableBegin = "recording,frame,object_id,distance_m,height_px,track_id,status,visible_points";

std::string cell(const std::optional<double>& value, int decimals) {
  constexpr int kWidth = 10;
  std::array<char, 40> text{};
  if (value) {
    std::snprintf(text.data(), text.size(), "%*.*f", kWidth, decimals, *value);
  } else {
    std::snprintf(text.data(), text.size(), "%*s", kWidth, "-");
  }
  return text.data();
}

std::string field(const std::optional<double>& value) {
  std::array<char, 40> text{};
  std::snprintf(text.data(), text.size(), "%.5f", value.value_or(0.0));
  return value ? text.data() : "";
}

drawing::Series curve(const std::vector<LimitRun>& runs, const LimitMetric& metric, std::string name, int style,
                      std::optional<double> (*value)(const LimitBin&)) {
  drawing::Series series;
  series.name = std::move(name);
  series.style = drawing::line_style(style);
  for (std::size_t i = 0; i + 1 < kLimitDistances_m.size(); ++i) {
    const LimitBin bin = limit_bin(runs, metric, i);
    if (const std::optional<double> y = value(bin)) {
      series.points.emplace_back(*bin.distance_m.mean(), *y);
    }
  }
  return series;
}

}  // namespace

std::optional<double> LimitBin::mean_ratio() const {
  if (ratios.empty()) {
    return std::nullopt;
  }
  return std::accumulate(ratios.begin(), ratios.end(), 0.0) / static_cast<double>(ratios.size());
}

std::optional<double> LimitBin::median_ratio() const {
  return ratios.empty() ? std::nullopt : std::optional(ratios[ratios.size() / 2]);
}

LimitBin limit_bin(const std::vector<LimitRun>& runs, const LimitMetric& metric, std::size_t index) {
  LimitBin bin;
  for (const LimitRun& run : runs) {
    for (const LimitRow& row : run.rows) {
      const double bound = row.bound.*metric.bound;
      if (row.run.distance_m < kLimitDistances_m[index] || row.run.distance_m >= kLimitDistances_m[index + 1] ||
          row.points == 0 || bound <= 0.0) {
        continue;
      }
      ++bin.frames;
      if (const std::optional<double> error = row.run.*metric.error) {
        bin.distance_m.add(row.run.distance_m);
        bin.error.add(*error);
        bin.bound.add(bound);
        bin.ratios.push_back(*error / bound);
      }
    }
  }
  std::sort(bin.ratios.begin(), bin.ratios.end());
  return bin;
}

std::string limit_tables(const std::vector<LimitRun>& runs) {
  std::string text;
  for (const LimitMetric& metric : kLimitMetrics) {
    text += metric.title;
    text += "\n  distance    frames  measured     error     bound     ratio    median\n";
    for (std::size_t i = 0; i + 1 < kLimitDistances_m.size(); ++i) {
      const LimitBin bin = limit_bin(runs, metric, i);
      std::array<char, 60> head{};
      std::snprintf(head.data(), head.size(), "%4.0f - %2.0f m%10zu%10zu", kLimitDistances_m[i],
                    kLimitDistances_m[i + 1], bin.frames, bin.ratios.size());
      text += head.data();
      text += cell(bin.error.mean(), 4) + cell(bin.bound.mean(), 4) + cell(bin.mean_ratio(), 2) +
              cell(bin.median_ratio(), 2) + "\n";
    }
    text += '\n';
  }
  return text;
}

Status check_limit_places(const fs::path& directory) {
  return first_failure(
      {check_same_kind(directory / "limit.csv", {"table of a study of limits",
                                                 [](const fs::path& path) { return begins_with(path, kTableBegin); }}),
       check_same_kind(directory / "limit.png", {"chart of a study of limits", &imaging::is_drawn_picture})});
}

Status write_limit_csv(const std::vector<LimitRun>& runs, const fs::path& directory) {
  std::ostringstream file;
  file << kTableBegin;
  for (const LimitMetric& metric : kLimitMetrics) {
    file << ',' << metric.name << ',' << metric.name << "_bound";
  }
  file << '\n';
  for (const LimitRun& run : runs) {
    for (const auto& [row, bound, points] : run.rows) {
      file << run.recording << ',' << row.frame << ',' << row.object_id << ',' << field(row.distance_m) << ','
           << row.height_px << ',' << row.track_id << ',' << to_string(row.status) << ',' << points;
      for (const LimitMetric& metric : kLimitMetrics) {
        file << ',' << field(row.*metric.error) << ',' << field(bound.*metric.bound);
      }
      file << '\n';
    }
  }
  return replace_file(directory / "limit.csv", file.str());
}

Status write_limit_plot(const std::vector<LimitRun>& runs, const fs::path& directory) {
  constexpr int kWidth_px = 1500;
  constexpr int kHeight_px = 460;
  constexpr double kGap_px = 12.0;
  drawing::Canvas canvas(kWidth_px, kHeight_px, drawing::kPaper);
  const double width = (kWidth_px - kGap_px) / static_cast<double>(kLimitMetrics.size());
  for (std::size_t m = 0; m < kLimitMetrics.size(); ++m) {
    const LimitMetric& metric = kLimitMetrics[m];
    drawing::Plot plot;
    plot.title = metric.title;
    plot.x.label = "distance [m]";
    plot.y.label = "error / Cramer-Rao bound";
    plot.y.logarithmic = true;
    plot.series.push_back(curve(runs, metric, "mean", 0, [](const LimitBin& bin) { return bin.mean_ratio(); }));
    plot.series.push_back(curve(runs, metric, "median", 1, [](const LimitBin& bin) { return bin.median_ratio(); }));
    draw_plot(canvas, {kGap_px + width * static_cast<double>(m), kGap_px, width - kGap_px, kHeight_px - 2.0 * kGap_px},
              plot);
  }
  return canvas.write_png(directory / "limit.png");
}

}  // namespace kinetrace::app
