// A camera as plans assume it, where there is none yet.
#pragma once

#include "camera/camera_setup.hpp"
#include "config/board_config.hpp"

namespace kinetrace::app {

/// Raw images of the board's size, as the most demanding kind: they have to be rectified.
[[nodiscard]] CameraSetup camera_of(const BoardConfig& board);

}  // namespace kinetrace::app
