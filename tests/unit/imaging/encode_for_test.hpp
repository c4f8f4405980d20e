// Image files of every kind, made in memory.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace kinetrace::imaging::test {

using Bytes = std::vector<std::uint8_t>;

struct PngKind {
  std::uint8_t color_type = 0;
  std::uint8_t bit_depth = 8;
  bool interlaced = false;
};

/// `pixels` in PNG layout: rows of host-endian samples, 1-, 2- and 4-bit samples packed. Palette images get the palette
/// entry i = (i, 2 i, 255 - i).
[[nodiscard]] Bytes encode_png(const PngKind& kind, int width, int height, const Bytes& pixels);
[[nodiscard]] Bytes encode_jpeg_gray(int width, int height, const Bytes& pixels);
[[nodiscard]] Bytes encode_jpeg_rgb(int width, int height, const Bytes& pixels);
[[nodiscard]] Bytes encode_jpeg_cmyk(int width, int height, const Bytes& pixels);
void write_file(const std::string& path, const Bytes& bytes);

}  // namespace kinetrace::imaging::test
