// From a target's markers to refined corners.
#pragma once

#include <array>
#include <vector>

#include <opencv2/core.hpp>

#include "detector.hpp"

namespace kinetrace::calibration {

/// A marker as detected.
struct SeenMarker {
  int id = 0;
  std::array<cv::Point2f, 4> corners_px;  ///< Clockwise from the top left one as printed.
};

/// Markers that agree on the target's position; this rejects misread markers and those of other boards. The first
/// corner of a marker is determined by its position among the others. None if fewer than two agree.
[[nodiscard]] std::vector<SeenMarker> consistent_markers(const Target& target, std::vector<SeenMarker> markers);

/// Corners of the target beside a consistent marker, with subpixel refinement.
[[nodiscard]] std::vector<Corner> refined_corners(const Target& target, const std::vector<SeenMarker>& markers,
                                                  const cv::Mat& image);

}  // namespace kinetrace::calibration
