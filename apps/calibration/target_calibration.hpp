// From the views that were collected to a calibration that is good enough, or a refusal that says what to do.
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
  std::vector<std::string> warnings;  ///< Good enough, but.
};

/// Errors: kBadCalibration, one line with all that is missing.
[[nodiscard]] Result<TargetCalibration> calibrate(const Target& target, const ViewCollector& views,
                                                  const EstimationOptions& options);

}  // namespace kinetrace::calibration
