// Errors of objects relative to their Cramer-Rao bounds, as a table and as a chart.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "kinetrace/core/result.hpp"
#include "kinetrace/evaluation/error_statistics.hpp"
#include "study/motion_bound.hpp"
#include "study/study_errors.hpp"

namespace kinetrace::app {

/// One object in one frame.
struct LimitRow {
  StudyRow run;
  PoseBound bound;
  std::size_t points = 0;  ///< Visible points in the bound.
};

struct LimitRun {
  std::string recording;
  PixelNoise noise;
  std::vector<LimitRow> rows;
};

struct LimitMetric {
  std::string_view title;
  std::string_view name;  ///< Of its columns.
  std::optional<double> StudyRow::*error = nullptr;
  double PoseBound::*bound = nullptr;
};
inline constexpr std::array<LimitMetric, 3> kLimitMetrics{{
    {"place [m]", "place_m", &StudyRow::published_place_m, &PoseBound::place_m},
    {"motion [m]", "motion_m", &StudyRow::published_motion_m, &PoseBound::motion_m},
    {"rotation [deg]", "motion_deg", &StudyRow::published_motion_deg, &PoseBound::motion_deg},
}};

/// Edges of the bins of distance in m.
inline constexpr std::array<double, 6> kLimitDistances_m{0.0, 10.0, 20.0, 30.0, 45.0, 60.0};

/// One metric in one bin.
struct LimitBin {
  std::size_t frames = 0;                  ///< Frames with a visible object and a bound.
  evaluation::ErrorStatistics distance_m;  ///< Of those measured.
  evaluation::ErrorStatistics error;
  evaluation::ErrorStatistics bound;
  std::vector<double> ratios;  ///< Error over bound, ascending.

  [[nodiscard]] std::optional<double> mean_ratio() const;
  [[nodiscard]] std::optional<double> median_ratio() const;
};
[[nodiscard]] LimitBin limit_bin(const std::vector<LimitRun>& runs, const LimitMetric& metric, std::size_t index);

/// A table for each metric: frames, those with an error, mean error, mean bound, mean and median of their ratio.
[[nodiscard]] std::string limit_tables(const std::vector<LimitRun>& runs);
/// Checks that limit.csv and limit.png replace those of an earlier study only. Errors: kOccupied.
[[nodiscard]] Status check_limit_places(const std::filesystem::path& directory);
/// Writes limit.csv, every object in every frame. Errors: kIo, naming the file.
[[nodiscard]] Status write_limit_csv(const std::vector<LimitRun>& runs, const std::filesystem::path& directory);
/// Writes limit.png. Errors: kIo.
[[nodiscard]] Status write_limit_plot(const std::vector<LimitRun>& runs, const std::filesystem::path& directory);

}  // namespace kinetrace::app
