// PNG files from images: for label images, results and tests. Not for the live path: encoding allocates.
#pragma once

#include <cstdint>

#include "kinetrace/core/export.hpp"
#include "kinetrace/core/image_view.hpp"
#include "kinetrace/core/result.hpp"
#include "kinetrace/imaging/rgb8.hpp"

namespace kinetrace::imaging {

/// kFast takes a fifth of the time for files a fifth larger; kFlat is quicker still for label images: few values over
/// wide areas.
enum class PngEffort : std::uint8_t { kSmall, kFast, kFlat };

/// Each writes one file, replacing an existing one as a whole or not at all. Errors: kInvalidArgument (empty image),
/// kIo (cannot be created or written).
[[nodiscard]] KINETRACE_API Status write_png_gray8(const char* path, GrayView image,
                                                   PngEffort effort = PngEffort::kSmall);
[[nodiscard]] KINETRACE_API Status write_png_gray16(const char* path, ImageView<const std::uint16_t> image,
                                                    PngEffort effort = PngEffort::kSmall);
[[nodiscard]] KINETRACE_API Status write_png_rgb8(const char* path, ImageView<const Rgb8> image,
                                                  PngEffort effort = PngEffort::kSmall);

}  // namespace kinetrace::imaging
