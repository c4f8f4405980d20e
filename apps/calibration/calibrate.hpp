// A calibration from its options to its files.
#pragma once

#include "calibration/calibrate_options.hpp"

namespace kinetrace::calibration {

/// Plays the recording or reads the camera, estimates, writes. Returns the exit code; errors have been printed.
[[nodiscard]] int calibrate_command(const app::CalibrateOptions& options);

}  // namespace kinetrace::calibration
