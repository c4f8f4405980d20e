// The tracked masks of a finished run as label images. For host-side tools; allocates.
#pragma once

#include <cstdint>
#include <filesystem>
#include <span>
#include <vector>

#include "kinetrace/core/export.hpp"
#include "kinetrace/core/image_view.hpp"
#include "kinetrace/core/result.hpp"
#include "kinetrace/recording/run_reader.hpp"

namespace kinetrace::recording {

/// The mask of a track in a frame.
struct FrameMask {
  std::uint8_t label = 0;  ///< Label of its pixels, from 1 in the order of the file.
  std::uint32_t track_id = 0;
  std::uint16_t class_id = 0;
  PixelBox box_px;
  std::int64_t area_px = 0;
};

/// One frame's masks; the views are valid until the next call of MaskFrames::at.
struct MaskFrame {
  LabelView labels;                  ///< FrameMask::label or kBackgroundLabel; empty if the run has no masks.
  std::span<const FrameMask> masks;  ///< Empty for a frame without rows in mots.txt.
};

/// Paints the masks of any frame. Memory: mots.txt and one image.
class KINETRACE_API MaskFrames {
 public:
  static constexpr std::size_t kMaxMasksPerFrame = kIgnoreLabel - 1;

  /// Without mots.txt no frame has masks. Errors: those of read_masks; kBadFormat (images of different sizes).
  [[nodiscard]] static Result<MaskFrames> open(const Run& run);

  /// Errors, with file, frame and track: kBadFormat (malformed run lengths, two masks on one pixel, the same track
  /// twice), kCapacity (more than kMaxMasksPerFrame masks).
  [[nodiscard]] Result<MaskFrame> at(std::int64_t frame);

 private:
  [[nodiscard]] Status paint(const MaskRow& row);
  [[nodiscard]] Unexpected<Error> damaged(const MaskRow& row, const std::string& reason, ErrorCode code) const;

  std::filesystem::path path_;
  std::vector<MaskRow> rows_;  ///< By frame.
  int width_ = 0;
  int height_ = 0;
  std::vector<std::uint8_t> labels_;
  std::vector<FrameMask> masks_;
};

}  // namespace kinetrace::recording
