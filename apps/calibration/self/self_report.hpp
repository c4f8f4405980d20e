// Reports of a self-calibration: lines, comments, JSON.
#pragma once

#include <string>
#include <vector>

#include "self_calibration.hpp"

namespace kinetrace::self_calibration {

/// Lines for the terminal.
[[nodiscard]] std::vector<std::string> report_lines(const SelfCalibration& result);
/// Comments for the calibration files. `images` names the recording.
[[nodiscard]] std::vector<std::string> remarks(const SelfCalibration& result, const std::string& images);
/// Everything, with the whole covariance, as JSON.
[[nodiscard]] std::string report_json(const SelfCalibration& result, const std::string& images);

}  // namespace kinetrace::self_calibration
