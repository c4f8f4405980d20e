// Instance masks as COCO compressed run lengths, the mask format of KITTI MOTS.
#pragma once

#include <cstdint>

#include "buffered_file.hpp"
#include "kinetrace/core/image_view.hpp"

namespace kinetrace::recording {

/// True if a pixel inside `box` has the value `label`.
[[nodiscard]] bool has_label(LabelView labels, const PixelBox& box, std::uint8_t label) noexcept;

/// Appends the pixels with value `label` inside `box` as a run-length string over the whole image. Only the box is
/// visited; the string goes straight to the file, so that no mask is too large.
///
/// Runs are counted down columns, left to right, beginning with background. From the fourth run on, the difference to
/// the count two before is stored. Each number is cut into groups of 5 bits, least significant first, until only copies
/// of the sign remain; bit 5 says that more follow, and 48 is added to make a printable character.
void write_mask_rle(LabelView labels, const PixelBox& box, std::uint8_t label, BufferedWriter& out) noexcept;

}  // namespace kinetrace::recording
