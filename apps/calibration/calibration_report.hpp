// What a calibration leaves behind: its files, and what it says about itself in lines, JSON and a picture.
#pragma once

#include <filesystem>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "kinetrace/core/result.hpp"
#include "target_calibration.hpp"

namespace kinetrace::calibration {

/// What was calibrated from, for those who read the report later.
struct ReportSource {
  std::string images;
  std::string target;
  std::string lens;
};

/// Lines for the terminal.
[[nodiscard]] std::vector<std::string> report_lines(const TargetCalibration& calibration);

/// Comments for the calibration files: from what, how good.
[[nodiscard]] std::vector<std::string> remarks(const TargetCalibration& calibration, const ReportSource& source);

/// Everything, with the whole covariance, as JSON.
[[nodiscard]] std::string report_json(const TargetCalibration& calibration, const ViewCollector& views,
                                      const ReportSource& source);

/// Four panels: where corners were seen in either image, and what the estimate leaves over there. Errors: kIo.
[[nodiscard]] Status write_picture(const TargetCalibration& calibration, const ViewCollector& views,
                                   const std::filesystem::path& path);

/// The folder for a calibration's files, made before images are looked at. If it is new and nothing was written into
/// it, it goes with this.
class OutputFolder {
 public:
  /// Looks also whether files can be written into it. Errors: kIo.
  [[nodiscard]] static Result<OutputFolder> make(const std::filesystem::path& folder);
  OutputFolder(OutputFolder&& other) noexcept : made_(std::exchange(other.made_, {})) {}
  OutputFolder& operator=(OutputFolder&&) = delete;
  ~OutputFolder();

 private:
  explicit OutputFolder(std::filesystem::path made) : made_(std::move(made)) {}

  std::filesystem::path made_;  ///< Empty if it was there.
};

/// calibration.yaml, and camchain.yaml where it can say what the lens is. Errors: kIo.
[[nodiscard]] Status write_calibration_files(const hal::RigCalibration& rig, const std::filesystem::path& folder,
                                             std::span<const std::string> head);

}  // namespace kinetrace::calibration
