// Tries a calibration on views that it was not made from.
#pragma once

#include <cstddef>
#include <span>

#include "detector.hpp"
#include "kinetrace/hal/rig_calibration.hpp"

namespace kinetrace::calibration {

struct Validation {
  std::size_t views = 0;
  std::size_t corners = 0;
  std::size_t rejected_corners = 0;  ///< Of a corner that lies far from its row, not the calibration is to blame.
  double epipolar_rms_px = 0.0;      ///< Difference of rows after rectification, in pixels of the raw images.
  double epipolar_max_px = 0.0;
  /// Lengths on the target as triangulated, relative to the true ones, minus one: mean and RMS. A wrong yaw or focal
  /// length shows here, a wrong size of the target does not.
  double length_error = 0.0;
  double length_rms = 0.0;
};

[[nodiscard]] Validation validate(const hal::RigCalibration& rig, const Target& target,
                                  std::span<const BoardView> views);

}  // namespace kinetrace::calibration
