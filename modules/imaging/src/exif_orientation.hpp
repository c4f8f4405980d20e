// How a camera says that a JPEG's pixels have to be turned before they are shown.
#pragma once

#include <cstddef>

#include "image_file.hpp"

namespace kinetrace::imaging {

inline constexpr int kExifUpright = 1;

/// Orientation (Exif 2.32, 4.6.4 A, tag 0x0112: 1 as stored, 2 to 8 mirrored or turned) of an APP1 segment whose
/// payload of `length` bytes begins at `offset` of `file`. 1 where it holds none or is damaged: it is no more than a
/// hint.
[[nodiscard]] int exif_orientation(const InputFile& file, std::size_t offset, std::size_t length);

}  // namespace kinetrace::imaging
