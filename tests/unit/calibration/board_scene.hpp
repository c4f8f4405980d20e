// Rigs and boards with known truth.
#pragma once

#include <cstdint>
#include <random>
#include <vector>

#include "detector.hpp"
#include "kinetrace/core/se3.hpp"
#include "kinetrace/hal/rig_calibration.hpp"
#include "lens.hpp"

namespace kinetrace::calibration::test {

/// 640x480 (times `scale`), 12 cm apart, turned against each other by a degree or two; with the distortion that the
/// lens can have.
[[nodiscard]] hal::RigCalibration true_rig(Lens lens, double scale = 1.0);

/// Motion of a board in front of the rig.
struct Motion {
  int views = 60;
  double max_tilt_rad = 0.6;
  double near_m = 0.35;
  double far_m = 1.0;
  double spread = 1.0;  ///< Over the image, 1: up to its borders.
};

/// T_left_board of boards in view, always the same ones for a seed.
[[nodiscard]] std::vector<Se3> board_poses(const hal::RigCalibration& rig, const Target& target, const Motion& motion,
                                           std::uint32_t seed);

/// Corners as the rig sees them, with Gaussian noise; corners outside an image are missing.
[[nodiscard]] std::vector<BoardView> ideal_views(const hal::RigCalibration& rig, const Target& target,
                                                 const std::vector<Se3>& poses, double noise_px, std::uint32_t seed);

}  // namespace kinetrace::calibration::test
