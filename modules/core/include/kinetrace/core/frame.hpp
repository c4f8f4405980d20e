// Input of the pipeline: stereo frames, raw and rectified.
#pragma once

#include <cstdint>
#include <string_view>

#include "kinetrace/core/image_view.hpp"
#include "kinetrace/core/stereo_geometry.hpp"

namespace kinetrace {

/// A synchronised pair as a camera delivers it: 8-bit luminance, possibly distorted. Views live until the camera's next
/// call.
struct StereoFrame {
  std::int64_t frame_index = 0;   ///< Numbering of the source; gaps mean lost frames.
  std::int64_t timestamp_ns = 0;  ///< Mid-exposure, in the source's clock.
  std::string_view name;          ///< File stem in a recording ("0000000012"), empty for live cameras.
  GrayView left;
  GrayView right;
};

/// The same pair after rectification: epipolar lines are rows, `geometry` holds exactly.
struct RectifiedPair {
  std::int64_t frame_index = 0;
  std::int64_t timestamp_ns = 0;
  std::string_view name;  ///< See StereoFrame::name.
  GrayView left;
  GrayView right;
  StereoGeometry geometry;
};

}  // namespace kinetrace
