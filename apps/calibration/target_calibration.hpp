// From the collected views to a sufficient calibration, or a refusal with its remedy.
#pragma once

#include <string>
#include <vector>

#include "kinetrace/core/result.hpp"
#include "stereo_estimation.hpp"
#include "validation.hpp"
#include "view_collector.hpp"

namespace kinetrace::calibration {

struct TargetCalibration {
  StereoEstimate estimate;            ///< From all views.
  Validation validation;              ///< On every fifth view, of an estimate from the others.
  std::vector<std::string> warnings;  ///< Shortcomings of an accepted calibration.
};

/// Errors: kBadCalibration, one line with all shortcomings.
[[nodiscard]] Result<TargetCalibration> calibrate(const Target& target, const ViewCollector& views,
                                                  const EstimationOptions& options);

}  // namespace kinetrace::calibration
