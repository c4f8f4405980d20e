// What a calibration says about itself: lines, JSON, a picture.
#pragma once

#include <filesystem>
#include <string>
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

}  // namespace kinetrace::calibration
