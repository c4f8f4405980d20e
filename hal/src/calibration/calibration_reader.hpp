// How a layout asks for the calibration of its recording.
#pragma once

#include <functional>

#include "kinetrace/core/result.hpp"
#include "kinetrace/hal/rig_calibration.hpp"

namespace kinetrace::hal {

struct ImageSize {
  int width_px = 0;
  int height_px = 0;
};

/// Makes the rig's calibration once the size of the images is known.
using CalibrationReader = std::function<Result<RigCalibration>(const ImageSize&)>;

}  // namespace kinetrace::hal
