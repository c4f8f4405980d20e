// Image sizes in calibration files.
#pragma once

#include <cmath>
#include <limits>

namespace kinetrace::hal {

/// A number of pixels; 0 if it is negative or not a number, the largest int if it is beyond that.
/// RigCalibration::validate checks its plausibility.
[[nodiscard]] inline int whole_pixels(double value) {
  constexpr double kMax = std::numeric_limits<int>::max();
  if (!(value > 0.0)) {
    return 0;
  }
  return value < kMax ? static_cast<int>(std::lround(value)) : std::numeric_limits<int>::max();
}

}  // namespace kinetrace::hal
