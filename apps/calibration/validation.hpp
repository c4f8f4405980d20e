// Validation of a calibration on views that it was not estimated from.
#pragma once

#include <cstddef>
#include <span>

#include "detector.hpp"
#include "kinetrace/hal/rig_calibration.hpp"

namespace kinetrace::calibration {

struct Validation {
  std::size_t views = 0;
  std::size_t corners = 0;
  std::size_t rejected_corners = 0;  ///< Far from their row: measurement errors, not errors of the calibration.
  double epipolar_rms_px = 0.0;      ///< Difference of rows after rectification, in pixels of the raw images.
  double epipolar_max_px = 0.0;
  /// Triangulated lengths on the target relative to the true ones, minus one: mean and RMS. Sensitive to a wrong yaw or
  /// focal length, not to a wrong size of the target.
  double length_error = 0.0;
  double length_rms = 0.0;
};

[[nodiscard]] Validation validate(const hal::RigCalibration& rig, const Target& target,
                                  std::span<const BoardView> views);

}  // namespace kinetrace::calibration
