// The camera assumed by plans without one.
#pragma once

#include "camera/camera_setup.hpp"
#include "config/board_config.hpp"

namespace kinetrace::app {

/// Raw images of the board's size that must be rectified: the most demanding case.
[[nodiscard]] CameraSetup camera_of(const BoardConfig& board);

}  // namespace kinetrace::app
