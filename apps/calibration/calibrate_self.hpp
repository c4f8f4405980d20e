// A calibration from a recording alone, from its options to its files.
#pragma once

#include "calibration/calibrate_options.hpp"

namespace kinetrace::calibration {

/// Reads the recording, estimates, writes. Returns the exit code; errors have been printed.
[[nodiscard]] int calibrate_self_command(const app::CalibrateOptions& options);

}  // namespace kinetrace::calibration
