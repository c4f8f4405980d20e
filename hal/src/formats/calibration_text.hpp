// A rig's calibration as text, exact in a round trip.
#pragma once

#include <string>
#include <string_view>

#include "kinetrace/core/result.hpp"
#include "kinetrace/hal/rig_calibration.hpp"

namespace kinetrace::hal {

/// Lines "key: numbers", see container_file.hpp.
[[nodiscard]] std::string calibration_text(const RigCalibration& rig);
/// Errors: kBadCalibration, naming `source`. The rig is not validated.
[[nodiscard]] Result<RigCalibration> parse_calibration_text(std::string_view text, const std::string& source);

/// The same rig as KITTI's calib_cam_to_cam.txt, cameras 00 and 01, with the rectification of `keep_borders` = 0.
/// Errors: kUnsupported (a lens that the file cannot hold), kBadCalibration.
[[nodiscard]] Result<std::string> kitti_calibration_text(const RigCalibration& rig);

}  // namespace kinetrace::hal
