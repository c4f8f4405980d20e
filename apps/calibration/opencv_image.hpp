// Images as OpenCV matrices.
#pragma once

#include <opencv2/core.hpp>

#include "kinetrace/core/image_view.hpp"

namespace kinetrace::calibration {

/// Shares the pixels, which OpenCV must not change.
[[nodiscard]] inline cv::Mat as_mat(GrayView image) {
  return {image.height, image.width, CV_8U, const_cast<std::uint8_t*>(image.data),
          static_cast<std::size_t>(image.stride)};
}

}  // namespace kinetrace::calibration
