// Tracks through a stretch of consecutive frames, in raw pixels.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <vector>

#include <Eigen/Core>

#include "kinetrace/core/frame.hpp"
#include "kinetrace/core/result.hpp"

namespace kinetrace::self_calibration {

/// Raw pairs by their index in a recording. A frame is valid until the next call.
struct FrameSource {
  std::size_t frames = 0;
  std::function<Result<StereoFrame>(std::size_t place)> read;
};

struct Observation {
  std::uint8_t view = 0;    ///< 0 left, 1 right.
  std::uint16_t frame = 0;  ///< Within the window.
  Eigen::Vector2d raw_px = Eigen::Vector2d::Zero();
};

/// One point; ordered by frame, left before right. Its first observation is a left one with a right one.
struct Track {
  std::vector<Observation> observations;
};

struct TrackWindow {
  std::vector<std::size_t> places;  ///< Of its frames in the recording.
  std::vector<Track> tracks;
};

}  // namespace kinetrace::self_calibration
