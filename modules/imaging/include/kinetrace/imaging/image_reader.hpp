// Image files into the caller's pixels: PNG (libspng), JPEG (libturbojpeg) and PGM.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <utility>

#include "kinetrace/core/arena.hpp"
#include "kinetrace/core/export.hpp"
#include "kinetrace/core/image_view.hpp"
#include "kinetrace/core/in_place_error.hpp"
#include "kinetrace/core/result.hpp"
#include "kinetrace/imaging/image_info.hpp"
#include "kinetrace/imaging/jpeg_decoder.hpp"
#include "kinetrace/imaging/rgb8.hpp"

namespace kinetrace::imaging {

/// The usual camera depth (8, 10, 12, 14 or 16 bits) for samples that need so many bits.
[[nodiscard]] constexpr int sample_bits_for(int used_bits) noexcept {
  return used_bits <= 8 ? 8 : used_bits + used_bits % 2;
}

/// Largest file that a reader accepts; larger ones are refused before a pixel is decoded.
struct KINETRACE_API ImageReaderConfig {
  int max_width_px = 2048;
  int max_height_px = 2048;
  std::size_t max_file_bytes = std::size_t{8} << 20;

  [[nodiscard]] Status validate() const;
};

/// Decodes one file at a time. Memory: `max_file_bytes` for the file and one row of pixels, from the arena; the codecs
/// allocate their own working memory inside each call (counted as foreign) and release it again. Own code never
/// allocates. One reader serves one thread.
class KINETRACE_API ImageReader {
 public:
  [[nodiscard]] static std::size_t required_bytes(const ImageReaderConfig& config);
  /// Errors: kInvalidConfig, kCapacity (arena too small).
  [[nodiscard]] static Result<ImageReader> create(const ImageReaderConfig& config, Arena& arena);

  /// The header of a file. Errors: as read_image_info; kBadFormat (beyond the reader's limits), naming the file and its
  /// size, before memory is taken for its pixels.
  [[nodiscard]] InPlaceResult<ImageInfo> inspect(const char* path) const;

  /// Decodes to 8-bit luminance. `target` must have the size of the image. Colour becomes Rec. 601 luma; 16-bit samples
  /// keep the upper eight of their `sample_bits` lowest bits, larger values are white (PGM with another maxval: scaled
  /// to 255); 1, 2 and 4-bit gray is scaled to 0..255; alpha is ignored. On an error the pixels of `target` are
  /// unspecified. Errors, all naming the file: kNotFound, kIo, kBadFormat (empty, truncated, damaged, beyond the
  /// reader's limits), kUnsupported (another format), kInvalidArgument (size differs from the target).
  [[nodiscard]] InPlaceStatus read_gray(const char* path, MutableGrayView target, int sample_bits = 16);

  /// Bits needed by the brightest sample of a grey 16-bit image: images of 10, 12 and 14-bit cameras are often stored
  /// unscaled, and the file does not tell. 16 for all other images, since their files define white. Errors: as
  /// read_gray.
  [[nodiscard]] InPlaceResult<int> used_bits(const char* path);

  /// Decodes to 8-bit colour; grey images have three equal samples. Otherwise as read_gray; kUnsupported for PGM.
  [[nodiscard]] InPlaceStatus read_rgb(const char* path, ImageView<Rgb8> target);

  /// Decodes a single-channel PNG of 8 or 16 bits, or a PGM, without any scaling: for label images (KITTI MOTS).
  /// Errors: as read_gray; kUnsupported for colour, palettes, fewer than 8 bits and JPEG.
  [[nodiscard]] InPlaceStatus read_gray16(const char* path, ImageView<std::uint16_t> target);

 private:
  explicit ImageReader(JpegDecoder jpeg) : jpeg_(std::move(jpeg)) {}
  struct Storage {
    std::span<std::uint8_t> file;
    std::span<std::uint8_t> row;
  };
  static void carve(const ImageReaderConfig& config, Arena& arena, Storage& storage);
  [[nodiscard]] InPlaceResult<ImageInfo> within_limits(const char* path, const ImageInfo& info) const;
  /// Reads the whole file into the storage and checks its header against the reader's and the target's size.
  [[nodiscard]] InPlaceResult<std::span<const std::uint8_t>> load(const char* path, int width, int height,
                                                                  ImageInfo& info);

  ImageReaderConfig config_;
  Storage storage_;
  JpegDecoder jpeg_;
};

}  // namespace kinetrace::imaging
