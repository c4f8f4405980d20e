// The pictures that a run was made from, rectified as it saw them.
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>

#include "kinetrace/core/arena.hpp"
#include "kinetrace/core/image_view.hpp"
#include "kinetrace/core/result.hpp"
#include "kinetrace/core/stereo_geometry.hpp"
#include "kinetrace/hal/dataset.hpp"
#include "kinetrace/hal/rectifier.hpp"
#include "kinetrace/imaging/image_reader.hpp"

namespace kinetrace::figure {

/// Left images of a recording in any order. Memory: one image file, one raw image and what the rectifier takes.
class RecordedImages {
 public:
  /// Opens the recording that the run folder names, or the same recording where it lies now: `moved_to` is LAYOUT:PATH,
  /// or empty. Errors: kInvalidArgument (not LAYOUT:PATH), kBadFormat (run.json), and those of open_dataset.
  [[nodiscard]] static Result<RecordedImages> open(const std::filesystem::path& run_directory,
                                                   const std::string& moved_to);

  [[nodiscard]] const StereoGeometry& geometry() const noexcept { return rectifier_.geometry(); }
  [[nodiscard]] const hal::FrameList& frames() const noexcept { return dataset_.frames; }
  /// File stem of a frame's left image; empty if the recording has no such frame.
  [[nodiscard]] std::string stem(std::int64_t frame) const;
  /// The rectified left image; lives until the next call. Errors: kNotFound (no such frame), and those of reading.
  [[nodiscard]] Result<GrayView> left(std::int64_t frame);

 private:
  RecordedImages(hal::Dataset dataset, std::unique_ptr<Arena> arena, imaging::ImageReader reader, MutableGrayView raw,
                 hal::Rectifier rectifier);

  hal::Dataset dataset_;
  std::unique_ptr<Arena> arena_;  ///< Holds everything below; does not move.
  imaging::ImageReader reader_;
  MutableGrayView raw_;
  hal::Rectifier rectifier_;
};

}  // namespace kinetrace::figure
