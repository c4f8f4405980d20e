// Binary PGM (P5), 8 and 16 bit.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "kinetrace/core/image_view.hpp"
#include "kinetrace/core/in_place_error.hpp"
#include "kinetrace/imaging/image_info.hpp"

namespace kinetrace::imaging {

struct PgmHeader {
  std::uint32_t width = 0;
  std::uint32_t height = 0;
  std::uint32_t max_value = 0;
  std::size_t pixels_offset = 0;
};

[[nodiscard]] InPlaceResult<PgmHeader> parse_pgm_header(const char* path, std::span<const std::uint8_t> bytes);
[[nodiscard]] InPlaceStatus decode_pgm_gray(const char* path, std::span<const std::uint8_t> bytes,
                                            MutableGrayView target, int sample_bits);
/// See ImageReader::used_bits; `info` is that of an image of 16 bits.
[[nodiscard]] InPlaceResult<int> used_bits_of_pgm(const char* path, std::span<const std::uint8_t> bytes,
                                                  const ImageInfo& info);
[[nodiscard]] InPlaceStatus decode_pgm_gray16(const char* path, std::span<const std::uint8_t> bytes,
                                              ImageView<std::uint16_t> target);

}  // namespace kinetrace::imaging
