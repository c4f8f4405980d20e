// JPEG through libturbojpeg.
#pragma once

#include <cstdint>
#include <span>

#include "kinetrace/core/image_view.hpp"
#include "kinetrace/core/result.hpp"
#include "kinetrace/imaging/image_reader.hpp"

namespace kinetrace::imaging {

/// Owns a decompressor, so that none is made per image.
struct ImageReader::JpegDecoder {
  void* handle = nullptr;

  /// Null on lack of memory.
  [[nodiscard]] static std::unique_ptr<JpegDecoder, JpegDecoderDelete> create();
  /// The size of `target` is that of the image. A warning (truncated, damaged) is an error.
  [[nodiscard]] Status decode_gray(const char* path, std::span<const std::uint8_t> bytes, MutableGrayView target) const;
};

}  // namespace kinetrace::imaging
