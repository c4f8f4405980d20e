// PNG through libspng, scan line by scan line.
#pragma once

#include <cstdint>
#include <span>

#include "kinetrace/core/image_view.hpp"
#include "kinetrace/core/in_place_error.hpp"
#include "kinetrace/imaging/image_info.hpp"
#include "kinetrace/imaging/rgb8.hpp"

namespace kinetrace::imaging {

inline constexpr int kPngRowBytesPerPixel = 4;  ///< Widest decoded pixel: 16-bit gray with alpha.

/// `row` holds at least width * kPngRowBytesPerPixel bytes; the size of `target` is that of the image.
[[nodiscard]] InPlaceStatus decode_png_gray(const char* path, std::span<const std::uint8_t> bytes,
                                            const ImageInfo& info, std::span<std::uint8_t> row, MutableGrayView target,
                                            int sample_bits);
/// See ImageReader::used_bits; `info` is that of a grey image of 16 bits.
[[nodiscard]] InPlaceResult<int> used_bits_of_png(const char* path, std::span<const std::uint8_t> bytes,
                                                  const ImageInfo& info, std::span<std::uint8_t> row);
[[nodiscard]] InPlaceStatus decode_png_rgb(const char* path, std::span<const std::uint8_t> bytes,
                                           std::span<std::uint8_t> row, ImageView<Rgb8> target);
[[nodiscard]] InPlaceStatus decode_png_gray16(const char* path, std::span<const std::uint8_t> bytes,
                                              const ImageInfo& info, std::span<std::uint8_t> row,
                                              ImageView<std::uint16_t> target);

}  // namespace kinetrace::imaging
