// Instance masks as COCO compressed run lengths, the mask format of KITTI MOTS.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <string_view>
#include <vector>

#include "kinetrace/core/export.hpp"
#include "kinetrace/core/image_view.hpp"
#include "kinetrace/core/result.hpp"

namespace kinetrace::imaging {

/// Pixels [begin, end) of a mask, counted down columns, left to right: pixel (x, y) is number x * height + y.
struct MaskRun {
  std::int64_t begin = 0;
  std::int64_t end = 0;
  friend bool operator==(const MaskRun&, const MaskRun&) = default;
};

/// True if a pixel inside `box` has the value `label`.
[[nodiscard]] KINETRACE_API bool has_label(LabelView labels, const PixelBox& box, std::uint8_t label) noexcept;

/// Turns the lengths of alternating runs, beginning with background, into text, one after the other.
///
/// From the fourth run on, the difference to the length two before is stored. Each number is cut into groups of 5 bits,
/// least significant first, until only copies of the sign remain; bit 5 marks a further group, and 48 is added to make
/// a printable character.
class KINETRACE_API RunLengthEncoder {
 public:
  /// The characters of the next length; they live until the next call.
  [[nodiscard]] std::string_view next(std::int64_t length) noexcept;

 private:
  std::array<char, 16> text_{};
  int index_ = 0;
  std::int64_t last_ = 0;
  std::int64_t before_last_ = 0;
};

/// Calls visit(MaskRun) for the longest runs of pixels with value `label` inside `box`, in order. Only the box is
/// visited. Never allocates.
template <typename Visit>
void for_each_mask_run(LabelView labels, const PixelBox& box, std::uint8_t label, Visit&& visit) {
  MaskRun run;
  const int y0 = std::max(box.y0, 0);
  const int y1 = std::min(box.y1, labels.height);
  for (int x = std::max(box.x0, 0); x < std::min(box.x1, labels.width); ++x) {
    const std::int64_t column = static_cast<std::int64_t>(x) * labels.height;
    for (int y = y0; y < y1; ++y) {
      if (labels.row(y)[x] != label) {
        continue;
      }
      const std::int64_t position = column + y;
      if (position != run.end || run.end == run.begin) {
        if (run.end > run.begin) {
          visit(run);
        }
        run.begin = position;
      }
      run.end = position + 1;
    }
  }
  if (run.end > run.begin) {
    visit(run);
  }
}

/// Calls append(std::string_view) with the pieces of the run-length string, over the whole image, of the pixels with
/// value `label` inside `box`. The string is never stored as a whole, so the size of a mask is unlimited. Never
/// allocates.
template <typename Append>
void encode_mask_rle(LabelView labels, const PixelBox& box, std::uint8_t label, Append&& append) {
  RunLengthEncoder encoder;
  std::int64_t written_end = 0;
  for_each_mask_run(labels, box, label, [&](const MaskRun& run) {
    append(encoder.next(run.begin - written_end));
    append(encoder.next(run.end - run.begin));
    written_end = run.end;
  });
  const std::int64_t pixels = static_cast<std::int64_t>(labels.width) * labels.height;
  if (pixels > written_end) {
    append(encoder.next(pixels - written_end));
  }
}

/// The foreground runs of a run-length string of an image of `width` x `height` pixels; empty runs are skipped.
/// Allocates. Errors, each with the place in the string: kBadFormat (a character outside the alphabet, the end within a
/// number, a number beyond 60 bits, a negative length, more or fewer pixels than the image has), kInvalidArgument (a
/// size below one pixel).
[[nodiscard]] KINETRACE_API Result<std::vector<MaskRun>> decode_mask_rle(std::string_view text, int width, int height);

}  // namespace kinetrace::imaging
