// A rig's calibration estimate as text.
#pragma once

#include <string>

#include "kinetrace/core/rig_correction.hpp"
#include "kinetrace/core/stereo_geometry.hpp"

namespace kinetrace::app {

/// "the right camera is turned by pitch 0.101 +-0.002, yaw ... degrees", with the resulting offset of disparities and
/// error of depths; or that it is as calibrated; or that the motion was insufficient. One line.
[[nodiscard]] std::string rig_text(const RigEstimate& rig, const StereoGeometry& geometry);

}  // namespace kinetrace::app
