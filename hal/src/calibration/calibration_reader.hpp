// Reads the calibration of a recording, once its image size is known.
#pragma once

#include <functional>

#include "kinetrace/core/result.hpp"
#include "kinetrace/hal/rig_calibration.hpp"

namespace kinetrace::hal {

struct ImageSize {
  int width_px = 0;
  int height_px = 0;
};

/// Makes the rig's calibration for images of this size.
using CalibrationReader = std::function<Result<RigCalibration>(const ImageSize&)>;

}  // namespace kinetrace::hal
