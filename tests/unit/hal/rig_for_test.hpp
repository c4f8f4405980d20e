// Rigs with known geometry.
#pragma once

#include "kinetrace/hal/rig_calibration.hpp"

namespace kinetrace::hal::test {

/// EuRoC-like: 752x480, radial-tangential, views turned against each other by about a degree.
[[nodiscard]] RigCalibration radial_rig();
/// Wide equidistant fisheye lenses, 640x480.
[[nodiscard]] RigCalibration fisheye_rig();
/// KITTI-like: raw 696x256 images with strong distortion, with rectifying matrices for 620x188.
[[nodiscard]] RigCalibration given_rig();
/// Already rectified: 48x32, f 40, baseline .5 m.
[[nodiscard]] RigCalibration rectified_rig();

}  // namespace kinetrace::hal::test
