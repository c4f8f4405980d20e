// JPEG in memory into the caller's pixels, through libturbojpeg.
#pragma once

#include <cstdint>
#include <memory>
#include <span>

#include "kinetrace/core/export.hpp"
#include "kinetrace/core/image_view.hpp"
#include "kinetrace/core/in_place_error.hpp"
#include "kinetrace/core/result.hpp"
#include "kinetrace/imaging/rgb8.hpp"

namespace kinetrace::imaging {

/// Owns a decompressor for reuse between images. The library allocates inside each call (counted as foreign). One
/// decoder serves one thread.
class KINETRACE_API JpegDecoder {
 public:
  /// Errors: kInternal (out of memory).
  [[nodiscard]] static Result<JpegDecoder> create();

  /// Decodes to 8-bit luminance. `name` begins the messages. A few stray bytes before the end mark, as many cameras
  /// write, are accepted. Errors: kBadFormat (no JPEG, truncated, damaged), kInvalidArgument (the image has another
  /// size than `target`). On an error the pixels of `target` are unspecified.
  [[nodiscard]] InPlaceStatus decode_gray(const char* name, std::span<const std::uint8_t> bytes,
                                          MutableGrayView target);

  /// The same in colour.
  [[nodiscard]] InPlaceStatus decode_rgb(const char* name, std::span<const std::uint8_t> bytes, ImageView<Rgb8> target);

 private:
  [[nodiscard]] InPlaceStatus decode(const char* name, std::span<const std::uint8_t> bytes, int format, int width,
                                     int height, int pitch_bytes, std::uint8_t* samples);
  struct Destroy {
    void operator()(void* handle) const noexcept;
  };
  std::unique_ptr<void, Destroy> handle_;
};

}  // namespace kinetrace::imaging
