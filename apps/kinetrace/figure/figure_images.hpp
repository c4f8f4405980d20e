// The recorded images of a run, rectified as in the run.
#pragma once

#include <cstdint>
#include <memory>
#include <string>

#include "kinetrace/core/arena.hpp"
#include "kinetrace/core/frame.hpp"
#include "kinetrace/core/image_view.hpp"
#include "kinetrace/core/result.hpp"
#include "kinetrace/core/stereo_geometry.hpp"
#include "kinetrace/hal/file_stereo_camera.hpp"
#include "kinetrace/hal/rectifier.hpp"
#include "kinetrace/recording/run_reader.hpp"

namespace kinetrace::figure {

/// Images of a recording with random access. Memory: a camera that plays it and the rectifier.
class RecordedImages {
 public:
  /// Opens the run's recording. `moved_to`: LAYOUT:PATH of a moved recording, or empty. Errors: kInvalidArgument (not
  /// LAYOUT:PATH), kBadFormat (the run does not name its recording, or this is another one), and those of open_dataset.
  [[nodiscard]] static Result<RecordedImages> open(const recording::Run& run, const std::string& moved_to);

  [[nodiscard]] const StereoGeometry& geometry() const noexcept { return rectifier_.geometry(); }
  [[nodiscard]] const hal::FrameList& frames() const noexcept { return camera_.dataset().frames; }
  /// File stem of a frame's left image, with "_passN" for further passes; empty if the recording has no such frame.
  [[nodiscard]] std::string stem(std::int64_t frame) const;
  /// The rectified images; valid until the next call. Errors: kNotFound (no such frame), and those of reading.
  [[nodiscard]] Result<RectifiedPair> pair(std::int64_t frame);
  [[nodiscard]] Result<GrayView> left(std::int64_t frame);

 private:
  /// Position of a frame in the recording.
  struct Found {
    std::size_t place = 0;  ///< In the list; its size if the frame is not there.
    std::int64_t pass = 0;  ///< From 0.
  };

  RecordedImages(std::unique_ptr<Arena> arena, hal::FileStereoCamera camera, hal::Rectifier rectifier,
                 std::int64_t passes);
  [[nodiscard]] Found find(std::int64_t frame) const;

  std::unique_ptr<Arena> arena_;  ///< Holds everything below; does not move.
  hal::FileStereoCamera camera_;
  hal::Rectifier rectifier_;
  std::int64_t passes_;
};

}  // namespace kinetrace::figure
