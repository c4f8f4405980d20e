// Output of a calibration: its files, and reports as lines, JSON and a picture.
#pragma once

#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include "kinetrace/core/result.hpp"
#include "target_calibration.hpp"

namespace kinetrace::calibration {

/// Source of the calibration, for the report.
struct ReportSource {
  std::string images;
  std::string target;
  std::string lens;
};

/// Lines for the terminal.
[[nodiscard]] std::vector<std::string> report_lines(const TargetCalibration& calibration);

/// Comments for the calibration files: source and quality.
[[nodiscard]] std::vector<std::string> remarks(const TargetCalibration& calibration, const ReportSource& source);

/// Everything, with the whole covariance, as JSON.
[[nodiscard]] std::string report_json(const TargetCalibration& calibration, const ViewCollector& views,
                                      const ReportSource& source);

/// Four panels: detected corners in both images, and their residuals. Errors: kIo.
[[nodiscard]] Status write_picture(const TargetCalibration& calibration, const ViewCollector& views,
                                   const std::filesystem::path& path);

/// Checks before images are processed that a calibration's files can be written into `folder`, and replace those of an
/// earlier calibration only. Leaves no new folder behind. Errors: kIo, kOccupied.
[[nodiscard]] Status check_output_folder(const std::filesystem::path& folder);

/// Makes the folder, and in it calibration.yaml, and camchain.yaml if it supports the lens model. Errors: kIo.
[[nodiscard]] Status write_calibration_files(const hal::RigCalibration& rig, const std::filesystem::path& folder,
                                             std::span<const std::string> head);

}  // namespace kinetrace::calibration
