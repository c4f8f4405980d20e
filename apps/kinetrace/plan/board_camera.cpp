#include "plan/board_camera.hpp"

#include <cstddef>

#include "kinetrace/hal/dataset.hpp"

namespace kinetrace::app {

CameraSetup camera_of(const BoardConfig& board) {
  const int width_px = board.image_width_px;
  const int height_px = board.image_height_px;
  hal::Dataset dataset;
  hal::CameraModel view;
  view.width_px = width_px;
  view.height_px = height_px;
  view.fx_px = 0.6 * width_px;
  view.fy_px = view.fx_px;
  view.cx_px = 0.5 * (width_px - 1);
  view.cy_px = 0.5 * (height_px - 1);
  view.distortion[0] = -0.1;  // Distortion, so that the plan includes rectification.
  dataset.calibration.source = "kinetrace plan";
  dataset.calibration.left = view;
  dataset.calibration.right = view;
  dataset.calibration.T_right_left.translation = {-0.5, 0.0, 0.0};
  // An uncompressed image.
  dataset.max_file_bytes = static_cast<std::size_t>(width_px) * static_cast<std::size_t>(height_px);
  return recording_setup(dataset);
}

}  // namespace kinetrace::app
