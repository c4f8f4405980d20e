// What is known about a rig's calibration, in words.
#pragma once

#include <string>

#include "kinetrace/core/rig_correction.hpp"
#include "kinetrace/core/stereo_geometry.hpp"

namespace kinetrace::app {

/// "the right camera is turned by pitch 0.101 +-0.002, yaw ... degrees", with the offset of disparities and the error
/// of depths that it means; that it is as calibrated; or that motion has not shown it. One line.
[[nodiscard]] std::string rig_text(const RigEstimate& rig, const StereoGeometry& geometry);

}  // namespace kinetrace::app
