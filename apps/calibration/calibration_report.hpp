// Output of a calibration: its files, and reports as lines, JSON and a picture.
#pragma once

#include <filesystem>
#include <span>
#include <string>
#include <utility>
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

/// The folder for a calibration's files, created before images are processed. A new folder without files is removed
/// again by the destructor.
class OutputFolder {
 public:
  /// Also checks that files can be written into it, and replace those of an earlier calibration only. Errors: kIo,
  /// kOccupied.
  [[nodiscard]] static Result<OutputFolder> make(const std::filesystem::path& folder);
  OutputFolder(OutputFolder&& other) noexcept : made_(std::exchange(other.made_, {})) {}
  OutputFolder& operator=(OutputFolder&&) = delete;
  ~OutputFolder();

 private:
  explicit OutputFolder(std::filesystem::path made) : made_(std::move(made)) {}

  std::filesystem::path made_;  ///< Empty if it existed before.
};

/// calibration.yaml, and camchain.yaml if it supports the lens model. Errors: kIo.
[[nodiscard]] Status write_calibration_files(const hal::RigCalibration& rig, const std::filesystem::path& folder,
                                             std::span<const std::string> head);

}  // namespace kinetrace::calibration
