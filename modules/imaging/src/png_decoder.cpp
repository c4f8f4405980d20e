#include "png_decoder.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <cstddef>
#include <cstring>
#include <memory>

#include <spng.h>

#include "image_file.hpp"
#include "kinetrace/core/allocation_counter.hpp"

namespace kinetrace::imaging {
namespace {

struct ContextDelete {
  void operator()(spng_ctx* context) const noexcept { spng_ctx_free(context); }
};
using Context = std::unique_ptr<spng_ctx, ContextDelete>;

// Pixels of an Adam7 pass (PNG specification, 8.2). Pass 0 of a plain image has start 0 and step 1.
struct Pass {
  int start;
  int step;
};
constexpr std::array<Pass, 7> kAdam7Columns{{{0, 8}, {4, 8}, {0, 4}, {2, 4}, {0, 2}, {1, 2}, {0, 1}}};

// Decodes in `format` and calls write_row(pixels, y, columns) for every scan line, `pixels` holding those of its pass.
template <typename WriteRow>
int decode_rows(std::span<const std::uint8_t> bytes, int format, std::span<std::uint8_t> row, WriteRow&& write_row) {
  const Context context(spng_ctx_new(0));
  if (!context) {
    return SPNG_EMEM;
  }
  // A valid chunk is no larger than its file: this bounds what a crafted header makes libspng allocate.
  spng_set_chunk_limits(context.get(), bytes.size(), bytes.size());
  spng_ihdr header{};
  int code = spng_set_png_buffer(context.get(), bytes.data(), bytes.size());
  if (code == SPNG_OK) {
    code = spng_get_ihdr(context.get(), &header);
  }
  if (code == SPNG_OK) {
    code = spng_decode_image(context.get(), nullptr, 0, format, SPNG_DECODE_PROGRESSIVE);
  }
  while (code == SPNG_OK) {
    spng_row_info info{};
    code = spng_get_row_info(context.get(), &info);
    if (code != SPNG_OK) {
      break;
    }
    code = spng_decode_scanline(context.get(), row.data(), row.size());
    if (code == SPNG_OK || code == SPNG_EOI) {
      const bool interlaced = header.interlace_method != SPNG_INTERLACE_NONE;
      write_row(row.data(), static_cast<int>(info.row_num),
                interlaced ? kAdam7Columns[static_cast<std::size_t>(info.pass)] : Pass{0, 1});
    }
  }
  // The last pixel may precede the checksum of its data: read on to the end chunk.
  return code == SPNG_EOI ? spng_decode_chunks(context.get()) : code;
}

InPlaceStatus to_status(int code, const char* path) {
  if (code == SPNG_OK) {
    return {};
  }
  const bool truncated = code == SPNG_IO_EOF || code == SPNG_EOF || code == SPNG_EIDAT_TOO_SHORT;
  return file_error(ErrorCode::kBadFormat, path,
                    {truncated ? "is truncated" : "is damaged", " (PNG decoder: ", spng_strerror(code),
                     "); copy it again or remove it"});
}

std::uint8_t luma(const std::uint8_t* rgb) {
  return static_cast<std::uint8_t>((77 * rgb[0] + 150 * rgb[1] + 29 * rgb[2] + 128) >> 8);  // Rec. 601.
}

// libspng's output format, and the conversion of its pixels to luminance.
struct GrayConversion {
  int format;
  int pixel_bytes;
  enum class Kind { kCopy, kUpperBits, kLuma } kind;
};

GrayConversion conversion_for(const ImageInfo& info) {
  if (info.channels >= 3) {
    return {SPNG_FMT_RGB8, 3, GrayConversion::Kind::kLuma};
  }
  if (info.bit_depth == 16) {
    return {SPNG_FMT_PNG, 2 * info.channels, GrayConversion::Kind::kUpperBits};
  }
  if (info.channels == 1) {
    return {SPNG_FMT_G8, 1, GrayConversion::Kind::kCopy};
  }
  return {SPNG_FMT_PNG, 2, GrayConversion::Kind::kCopy};
}

std::uint16_t native16(const std::uint8_t* bytes) {
  std::uint16_t value = 0;
  std::memcpy(&value, bytes, sizeof value);
  return value;
}

std::uint8_t to_gray(const std::uint8_t* pixel, GrayConversion::Kind kind, int sample_bits) {
  switch (kind) {
    case GrayConversion::Kind::kCopy: return *pixel;
    case GrayConversion::Kind::kUpperBits: return upper_bits(native16(pixel), sample_bits);
    case GrayConversion::Kind::kLuma: return luma(pixel);
  }
  return 0;
}

}  // namespace

InPlaceStatus decode_png_gray(const char* path, std::span<const std::uint8_t> bytes, const ImageInfo& info,
                              std::span<std::uint8_t> row, MutableGrayView target, int sample_bits) {
  const GrayConversion conversion = conversion_for(info);
  int code = SPNG_OK;
  {
    const ForeignCall foreign;
    code = decode_rows(bytes, conversion.format, row, [&](const std::uint8_t* pixel, int y, Pass columns) {
      std::uint8_t* out = target.row(y);
      for (int x = columns.start; x < target.width; x += columns.step, pixel += conversion.pixel_bytes) {
        out[x] = to_gray(pixel, conversion.kind, sample_bits);
      }
    });
  }
  return to_status(code, path);
}

InPlaceResult<int> used_bits_of_png(const char* path, std::span<const std::uint8_t> bytes, const ImageInfo& info,
                                    std::span<std::uint8_t> row) {
  unsigned all = 0;
  int code = SPNG_OK;
  {
    const ForeignCall foreign;
    const int pixel_bytes = 2 * info.channels;
    code = decode_rows(bytes, SPNG_FMT_PNG, row, [&](const std::uint8_t* pixel, int /*y*/, Pass columns) {
      for (int x = columns.start; x < info.width; x += columns.step, pixel += pixel_bytes) {
        all |= native16(pixel);
      }
    });
  }
  const InPlaceStatus decoded = to_status(code, path);
  return decoded ? InPlaceResult<int>(std::bit_width(all)) : Unexpected(decoded.error());
}

InPlaceStatus decode_png_rgb(const char* path, std::span<const std::uint8_t> bytes, std::span<std::uint8_t> row,
                             ImageView<Rgb8> target) {
  int code = SPNG_OK;
  {
    const ForeignCall foreign;
    code = decode_rows(bytes, SPNG_FMT_RGB8, row, [&](const std::uint8_t* pixel, int y, Pass columns) {
      Rgb8* out = target.row(y);
      for (int x = columns.start; x < target.width; x += columns.step, pixel += 3) {
        out[x] = {pixel[0], pixel[1], pixel[2]};
      }
    });
  }
  return to_status(code, path);
}

InPlaceStatus decode_png_gray16(const char* path, std::span<const std::uint8_t> bytes, const ImageInfo& info,
                                std::span<std::uint8_t> row, ImageView<std::uint16_t> target) {
  if (info.channels != 1 || info.bit_depth < 8) {
    return file_error(ErrorCode::kUnsupported, path, {"is no label image; expected a gray PNG of 8 or 16 bits"});
  }
  int code = SPNG_OK;
  {
    const ForeignCall foreign;
    code = decode_rows(bytes, SPNG_FMT_PNG, row, [&](const std::uint8_t* pixel, int y, Pass columns) {
      std::uint16_t* out = target.row(y);
      const int pixel_bytes = info.bit_depth / 8;
      for (int x = columns.start; x < target.width; x += columns.step, pixel += pixel_bytes) {
        out[x] = pixel_bytes == 2 ? native16(pixel) : *pixel;
      }
    });
  }
  return to_status(code, path);
}

}  // namespace kinetrace::imaging
