#include "kinetrace/imaging/png_writer.hpp"

#include <cerrno>
#include <cstddef>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <string>

#include <spng.h>

#include "image_file.hpp"
#include "kinetrace/core/allocation_counter.hpp"
#include "kinetrace/core/files.hpp"

namespace kinetrace::imaging {
namespace {

struct FileClose {
  void operator()(std::FILE* file) const noexcept { (void)std::fclose(file); }
};
struct ContextDelete {
  void operator()(spng_ctx* context) const noexcept { spng_ctx_free(context); }
};

struct PixelFormat {
  std::uint8_t bit_depth;
  std::uint8_t color_type;
};

constexpr int kRunsOnly = 3;  // zlib's Z_RLE.

bool is_photograph(PixelFormat format) {
  return format.bit_depth == 8 && format.color_type == SPNG_COLOR_TYPE_GRAYSCALE;
}

// Trying every filter on every row costs more than the deflation that follows. Readers undo differences to the row
// above many pixels at a time, but differences to the left pixel one by one, which doubles the time of reading.
int filter_for(PngEffort effort) {
  return effort == PngEffort::kFlat ? SPNG_FILTER_CHOICE_NONE : SPNG_FILTER_CHOICE_UP;
}

int set_effort(spng_ctx* context, PixelFormat format, PngEffort effort) {
  if (effort == PngEffort::kSmall) {
    return SPNG_OK;
  }
  int code = spng_set_option(context, SPNG_FILTER_CHOICE, filter_for(effort));
  if (code == SPNG_OK) {
    code = spng_set_option(context, SPNG_IMG_COMPRESSION_LEVEL, 1);
  }
  if (code == SPNG_OK && effort == PngEffort::kFast && is_photograph(format)) {
    // Noise never repeats: a search beyond runs takes longer and finds less.
    code = spng_set_option(context, SPNG_IMG_COMPRESSION_STRATEGY, kRunsOnly);
  }
  return code;
}

template <typename Pixel>
int encode(std::FILE* file, ImageView<const Pixel> image, PixelFormat format, PngEffort effort) {
  const std::unique_ptr<spng_ctx, ContextDelete> context(spng_ctx_new(SPNG_CTX_ENCODER));
  if (!context) {
    return SPNG_EMEM;
  }
  spng_ihdr header{};
  header.width = static_cast<std::uint32_t>(image.width);
  header.height = static_cast<std::uint32_t>(image.height);
  header.bit_depth = format.bit_depth;
  header.color_type = format.color_type;
  int code = spng_set_png_file(context.get(), file);
  if (code == SPNG_OK) {
    code = spng_set_ihdr(context.get(), &header);
  }
  if (code == SPNG_OK) {
    code = set_effort(context.get(), format, effort);
  }
  if (code == SPNG_OK) {
    code = spng_encode_image(context.get(), nullptr, 0, SPNG_FMT_PNG, SPNG_ENCODE_PROGRESSIVE | SPNG_ENCODE_FINALIZE);
  }
  for (int y = 0; code == SPNG_OK && y < image.height; ++y) {
    code = spng_encode_row(context.get(), image.row(y), static_cast<std::size_t>(image.width) * sizeof(Pixel));
  }
  return code == SPNG_EOI ? SPNG_OK : code;
}

template <typename Pixel>
Status write(const char* path, ImageView<const Pixel> image, PixelFormat format, PngEffort effort) {
  if (image.empty()) {
    return file_error(ErrorCode::kInvalidArgument, path, {"cannot be written: the image is empty"});
  }
  const ForeignCall foreign;
  const std::filesystem::path staged = staged_path(path);
  const int descriptor = open_staged(staged);
  const bool is_folder = descriptor < 0 && errno == EISDIR;
  std::unique_ptr<std::FILE, FileClose> file(::fdopen(descriptor, "wb"));
  if (!file) {
    return file_error(
        ErrorCode::kIo, path,
        {is_folder ? "is a folder; name a file" : "cannot be created; check that the folder exists and is writable"});
  }
  const int code = encode(file.get(), image, format, effort);
  const bool flushed = std::fclose(file.release()) == 0;
  if (code != SPNG_OK || !flushed) {
    discard_staged(staged, path);
    return file_error(
        ErrorCode::kIo, path,
        {"cannot be written (", code != SPNG_OK ? spng_strerror(code) : "close failed", "); check the free space"});
  }
  return put_in_place(staged, path);
}

}  // namespace

Status write_png_gray8(const char* path, GrayView image, PngEffort effort) {
  return write(path, image, {8, SPNG_COLOR_TYPE_GRAYSCALE}, effort);
}
Status write_png_gray16(const char* path, ImageView<const std::uint16_t> image, PngEffort effort) {
  return write(path, image, {16, SPNG_COLOR_TYPE_GRAYSCALE}, effort);
}
Status write_png_rgb8(const char* path, ImageView<const Rgb8> image, PngEffort effort) {
  static_assert(sizeof(Rgb8) == 3);
  return write(path, image, {8, SPNG_COLOR_TYPE_TRUECOLOR}, effort);
}

}  // namespace kinetrace::imaging
