// Errors of many frames as tables: over distance and over height in the image.
#pragma once

#include <array>
#include <cstddef>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "kinetrace/core/result.hpp"
#include "kinetrace/evaluation/error_statistics.hpp"
#include "study/study_errors.hpp"

namespace kinetrace::app {

/// One recording reconstructed with one setting.
struct StudyRun {
  std::string recording;
  std::string window;  ///< Number of frames, or "default" for the configuration as it is.
  std::vector<StudyRow> rows;
};

struct StudyMetric {
  std::string_view name;   ///< Of its column.
  std::string_view title;  ///< For charts and tables.
  std::string_view unit;
  bool in_tables = false;  ///< Shown on the terminal; all are in the files.
  bool in_plot = false;
  std::optional<double> StudyRow::*value = nullptr;
};
inline constexpr std::array<StudyMetric, 8> kStudyMetrics{{
    {"position_m", "position, constant offset removed", "m", true, true, &StudyRow::position_m},
    {"center_m", "centre of the box, nothing removed", "m", false, false, &StudyRow::center_m},
    {"motion_m", "motion between frames", "m", true, true, &StudyRow::motion_m},
    {"motion_deg", "rotation between frames", "deg", true, true, &StudyRow::motion_deg},
    {"depth_bias_m", "distance of the seen surface", "m", true, false, &StudyRow::depth_bias_m},
    {"depth_m", "depth of a point", "m", false, false, &StudyRow::depth_m},
    {"shape_m", "shape: depth of a point", "m", true, true, &StudyRow::shape_m},
    {"wrong_points", "points off by a fifth of the distance", "1", false, false, &StudyRow::wrong_points},
}};

/// Quantity of the bins.
struct StudyAxis {
  std::string_view name;
  std::vector<double> edges;  ///< Bins lie between neighbours.
  [[nodiscard]] double value(const StudyRow& row) const;
};
[[nodiscard]] const std::array<StudyAxis, 2>& study_axes();

/// Bins with fewer measurements are shown as empty.
inline constexpr std::size_t kStudyMinMeasurements = 10;

/// All frames of a bin.
struct StudyBin {
  std::size_t frames = 0;   ///< Frames with a visible object.
  std::size_t tracked = 0;  ///< Frames with a pose from its own reconstruction.
  evaluation::ErrorStatistics axis;
  std::array<evaluation::ErrorStatistics, kStudyMetrics.size()> errors;  ///< As kStudyMetrics.

  /// Root mean square of a metric, for display.
  [[nodiscard]] std::optional<double> shown(std::size_t metric) const noexcept {
    return errors[metric].count() >= kStudyMinMeasurements ? errors[metric].rmse() : std::nullopt;
  }
};
/// Bin `index` of the runs with this window; of one recording, or of all if `recording` is empty.
[[nodiscard]] StudyBin study_bin(const std::vector<StudyRun>& runs, std::string_view window, std::string_view recording,
                                 const StudyAxis& axis, std::size_t index);

/// The windows, and the recordings, in the order of the runs.
[[nodiscard]] std::vector<std::string> windows_of(const std::vector<StudyRun>& runs);
[[nodiscard]] std::vector<std::string> recordings_of(const std::vector<StudyRun>& runs);

/// Checks that the files below replace those of an earlier study only. Errors: kOccupied.
[[nodiscard]] Status check_study_places(const std::filesystem::path& directory);
/// Writes frames.csv and bins.csv. Errors: kIo, naming the file.
[[nodiscard]] Status write_study_csv(const std::vector<StudyRun>& runs, const std::filesystem::path& directory);
/// Writes object_size.png. Errors: kIo.
[[nodiscard]] Status write_study_plot(const std::vector<StudyRun>& runs, const std::filesystem::path& directory);
/// The tables for the terminal, by distance.
[[nodiscard]] std::string study_tables(const std::vector<StudyRun>& runs);

}  // namespace kinetrace::app
