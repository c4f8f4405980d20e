// What an image file holds, from its header alone.
#pragma once

#include <cstdint>
#include <filesystem>

#include "kinetrace/core/export.hpp"
#include "kinetrace/core/in_place_error.hpp"

namespace kinetrace::imaging {

inline constexpr int kMaxImageSide_px = 16384;

enum class ImageFormat : std::uint8_t { kPng, kPgm, kJpeg };

/// Header of an image file.
struct ImageInfo {
  ImageFormat format = ImageFormat::kPng;
  int width = 0;
  int height = 0;
  int channels = 0;   ///< Stored channels: 1 gray, 2 gray + alpha, 3 colour (palettes too), 4 colour + alpha.
  int bit_depth = 0;  ///< Bits per channel of the file: 1, 2, 4, 8 or 16.
};

/// Reads the header of a PNG, PGM (P5) or JPEG file, chosen by content, not by name. Never allocates unless it fails.
/// Its size is safe for taking memory: a file holds at least a thousandth of its pixels, in bytes.
/// Errors: kNotFound, kIo, kBadFormat (no regular file, empty, truncated, more than 16384 pixels wide or high, more
/// pixels than a file of its length can hold), kUnsupported (another image format, or a JPEG whose Exif orientation
/// says that it is to be turned).
[[nodiscard]] KINETRACE_API InPlaceResult<ImageInfo> read_image_info(const char* path);

/// Whether a file is a PNG with so many channels and bits per channel, by its header: the kind of a result's file, see
/// FileKind of core/files.hpp.
[[nodiscard]] KINETRACE_API bool is_png(const char* path, int channels, int bit_depth);
/// A PNG of 8-bit colours, as all charts, figures and overlays are.
[[nodiscard]] KINETRACE_API bool is_drawn_picture(const std::filesystem::path& path);

}  // namespace kinetrace::imaging
