// From the markers of a target to the corners that are measured.
#pragma once

#include <array>
#include <vector>

#include <opencv2/core.hpp>

#include "detector.hpp"

namespace kinetrace::calibration {

/// A marker as a detector of markers found it.
struct SeenMarker {
  int id = 0;
  std::array<cv::Point2f, 4> corners_px;  ///< Clockwise from the top left one as it is printed.
};

/// Markers that agree with each other about where the target lies: of one that was misread, or stands on another board,
/// the corners are elsewhere. Which corner of a marker is the first is decided by its place among the others. None if
/// fewer than two agree.
[[nodiscard]] std::vector<SeenMarker> consistent_markers(const Target& target, std::vector<SeenMarker> markers);

/// Corners of the target that have a consistent marker beside them, refined to a part of a pixel.
[[nodiscard]] std::vector<Corner> refined_corners(const Target& target, const std::vector<SeenMarker>& markers,
                                                  const cv::Mat& image);

}  // namespace kinetrace::calibration
