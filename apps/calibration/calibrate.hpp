// A calibration from its options to its files.
#pragma once

#include "calibration/calibrate_options.hpp"

namespace kinetrace::calibration {

/// Plays the recording or watches the camera, estimates, writes. Returns the exit code; what is wrong has been said.
[[nodiscard]] int calibrate_command(const app::CalibrateOptions& options);

}  // namespace kinetrace::calibration
