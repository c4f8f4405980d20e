#include "study/study_summary.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <limits>
#include <sstream>

#include "kinetrace/core/config_check.hpp"
#include "kinetrace/core/files.hpp"
#include "kinetrace/imaging/image_info.hpp"

namespace kinetrace::app {
namespace {

namespace fs = std::filesystem;

// The tables begin with these, by which those of an earlier study are recognised.
constexpr const char* kFramesBegin = "recording,window,frame,object_id,distance_m,height_px,track_id,status,points";
constexpr const char* kBinsBegin = "by,from,to,window,recording,frames,tracked";

constexpr double kNoLimit = std::numeric_limits<double>::infinity();

std::string number(double value, int decimals) {
  std::array<char, 40> text{};
  std::snprintf(text.data(), text.size(), "%.*f", decimals, value);
  return text.data();
}

std::string field(const std::optional<double>& value) {
  constexpr int kDecimals = 5;
  return value ? number(*value, kDecimals) : "";
}

template <typename Name>
std::vector<std::string> distinct(const std::vector<StudyRun>& runs, Name StudyRun::*name) {
  std::vector<std::string> names;
  for (const StudyRun& run : runs) {
    if (std::find(names.begin(), names.end(), run.*name) == names.end()) {
      names.push_back(run.*name);
    }
  }
  return names;
}

Status write_frames(const std::vector<StudyRun>& runs, const fs::path& path) {
  std::ostringstream file;
  file << kFramesBegin;
  for (const StudyMetric& metric : kStudyMetrics) {
    file << ',' << metric.name;
  }
  file << '\n';
  for (const StudyRun& run : runs) {
    for (const StudyRow& row : run.rows) {
      file << run.recording << ',' << run.window << ',' << row.frame << ',' << row.object_id << ','
           << field(row.distance_m) << ',' << row.height_px << ',' << row.track_id << ',' << to_string(row.status)
           << ',' << row.points;
      for (const StudyMetric& metric : kStudyMetrics) {
        file << ',' << field(row.*metric.value);
      }
      file << '\n';
    }
  }
  return replace_file(path, file.str());
}

Status write_bins(const std::vector<StudyRun>& runs, const fs::path& path) {
  std::ostringstream file;
  file << kBinsBegin;
  for (const StudyMetric& metric : kStudyMetrics) {
    file << ',' << metric.name;
  }
  file << '\n';
  std::vector<std::string> recordings = recordings_of(runs);
  recordings.insert(recordings.begin(), "");
  for (const StudyAxis& axis : study_axes()) {
    for (std::size_t i = 0; i + 1 < axis.edges.size(); ++i) {
      for (const std::string& window : windows_of(runs)) {
        for (const std::string& recording : recordings) {
          const StudyBin bin = study_bin(runs, window, recording, axis, i);
          file << axis.name << ',' << axis.edges[i] << ',' << axis.edges[i + 1] << ',' << window << ','
               << (recording.empty() ? "all" : recording) << ',' << bin.frames << ',' << bin.tracked;
          for (const evaluation::ErrorStatistics& errors : bin.errors) {
            file << ',' << field(errors.rmse());
          }
          file << '\n';
        }
      }
    }
  }
  return replace_file(path, file.str());
}

void append_cell(std::string& text, const std::string& cell, std::size_t width) {
  text.append(cell.size() < width ? width - cell.size() : 1, ' ');
  text += cell;
}

std::string range_text(const StudyAxis& axis, std::size_t i) {
  std::string text = std::isfinite(axis.edges[i + 1]) ? "" : "over ";
  text += number(axis.edges[i], 0);
  if (std::isfinite(axis.edges[i + 1])) {
    text.append("-").append(number(axis.edges[i + 1], 0));
  }
  return text;
}

constexpr std::size_t kColumn = 9;

/// `cell` turns a bin into text.
template <typename Cell>
void append_table(std::string& text, const std::vector<StudyRun>& runs, const std::string& title, Cell cell) {
  const StudyAxis& axis = study_axes().front();
  const std::vector<std::string> windows = windows_of(runs);
  text += title;
  text += '\n';
  for (const char* heading : {"distance", "frames"}) {
    append_cell(text, heading, kColumn);
  }
  for (const std::string& window : windows) {
    append_cell(text, window, kColumn);
  }
  text += '\n';
  for (std::size_t i = 0; i + 1 < axis.edges.size(); ++i) {
    const std::size_t frames = study_bin(runs, windows.front(), "", axis, i).frames;
    if (frames == 0) {
      continue;
    }
    append_cell(text, range_text(axis, i), kColumn);
    append_cell(text, std::to_string(frames), kColumn);
    for (const std::string& window : windows) {
      append_cell(text, cell(study_bin(runs, window, "", axis, i)), kColumn);
    }
    text += '\n';
  }
  text += '\n';
}

}  // namespace

double StudyAxis::value(const StudyRow& row) const {
  return name == "distance_m" ? row.distance_m : static_cast<double>(row.height_px);
}

const std::array<StudyAxis, 2>& study_axes() {
  static const std::array<StudyAxis, 2> axes{{
      {"distance_m", {0.0, 10.0, 20.0, 30.0, 40.0, 50.0, 60.0, 70.0, 80.0, kNoLimit}},
      {"height_px", {0.0, 16.0, 20.0, 24.0, 32.0, 48.0, 64.0, 96.0, kNoLimit}},
  }};
  return axes;
}

StudyBin study_bin(const std::vector<StudyRun>& runs, std::string_view window, std::string_view recording,
                   const StudyAxis& axis, std::size_t index) {
  StudyBin bin;
  for (const StudyRun& run : runs) {
    if (run.window != window || (!recording.empty() && run.recording != recording)) {
      continue;
    }
    for (const StudyRow& row : run.rows) {
      const double value = axis.value(row);
      if (value < axis.edges[index] || value >= axis.edges[index + 1]) {
        continue;
      }
      ++bin.frames;
      bin.tracked += row.status == BodyStatus::kTracked ? 1U : 0U;
      bin.axis.add(value);
      for (std::size_t m = 0; m < kStudyMetrics.size(); ++m) {
        if (const std::optional<double> error = row.*kStudyMetrics[m].value) {
          bin.errors[m].add(std::abs(*error));
        }
      }
    }
  }
  return bin;
}

std::vector<std::string> windows_of(const std::vector<StudyRun>& runs) {
  return distinct(runs, &StudyRun::window);
}

std::vector<std::string> recordings_of(const std::vector<StudyRun>& runs) {
  return distinct(runs, &StudyRun::recording);
}

Status check_study_places(const fs::path& directory) {
  constexpr std::string_view kTable = "table of a study";
  return first_failure(
      {check_same_kind(directory / "frames.csv",
                       {kTable, [](const fs::path& path) { return begins_with(path, kFramesBegin); }}),
       check_same_kind(directory / "bins.csv",
                       {kTable, [](const fs::path& path) { return begins_with(path, kBinsBegin); }}),
       check_same_kind(directory / "object_size.png", {"chart of a study", &imaging::is_drawn_picture})});
}

Status write_study_csv(const std::vector<StudyRun>& runs, const fs::path& directory) {
  Status written = write_frames(runs, directory / "frames.csv");
  return written ? write_bins(runs, directory / "bins.csv") : written;
}

std::string study_tables(const std::vector<StudyRun>& runs) {
  std::string text = "By distance in m; columns: frames of the object's window.\n\n";
  append_table(text, runs, "frames with a pose from the object's reconstruction [%]", [](const StudyBin& bin) {
    return number(100.0 * static_cast<double>(bin.tracked) / static_cast<double>(bin.frames), 0);
  });
  for (std::size_t m = 0; m < kStudyMetrics.size(); ++m) {
    const StudyMetric& metric = kStudyMetrics[m];
    if (!metric.in_tables) {
      continue;
    }
    std::string title(metric.title);
    title.append(", RMS [").append(metric.unit).append("]");
    append_table(text, runs, title, [m](const StudyBin& bin) {
      constexpr int kDecimals = 3;
      const std::optional<double> rmse = bin.shown(m);
      return rmse ? number(*rmse, kDecimals) : "-";
    });
  }
  return text;
}

}  // namespace kinetrace::app
