#include "kinetrace/imaging/jpeg_decoder.hpp"

#include <cstdio>

#include <turbojpeg.h>

#include "image_file.hpp"
#include "kinetrace/core/allocation_counter.hpp"

namespace kinetrace::imaging {
namespace {

// Decoding stops at the first warning. A warning about a few bytes before the end mark leaves all pixels intact,
// because the decoder looks for the mark after the last row. More bytes than alignment explains are missing rows.
bool is_padding(const char* warning) {
  constexpr unsigned kMaxBytes = 16;
  constexpr unsigned kEndOfImage = 0xd9;
  unsigned bytes = 0;
  unsigned marker = 0;
  return std::sscanf(warning, "Corrupt JPEG data: %u extraneous bytes before marker 0x%x", &bytes, &marker) == 2 &&
         bytes <= kMaxBytes && marker == kEndOfImage;
}

Unexpected<InPlaceError> damaged(const char* name, const char* reason) {
  return file_error(ErrorCode::kBadFormat, name,
                    {"is damaged or truncated (JPEG decoder: ", reason, "); copy it again or remove it"});
}

}  // namespace

void JpegDecoder::Destroy::operator()(void* handle) const noexcept {
  tjDestroy(handle);
}

Result<JpegDecoder> JpegDecoder::create() {
  JpegDecoder decoder;
  decoder.handle_.reset(tjInitDecompress());
  if (!decoder.handle_) {
    return fail(ErrorCode::kInternal, "libturbojpeg gives no decompressor: out of memory");
  }
  return decoder;
}

InPlaceStatus JpegDecoder::decode_gray(const char* name, std::span<const std::uint8_t> bytes, MutableGrayView target) {
  return decode(name, bytes, TJPF_GRAY, target.width, target.height, target.stride, target.data);
}

InPlaceStatus JpegDecoder::decode_rgb(const char* name, std::span<const std::uint8_t> bytes, ImageView<Rgb8> target) {
  static_assert(sizeof(Rgb8) == 3);
  return decode(name, bytes, TJPF_RGB, target.width, target.height, 3 * target.stride,
                reinterpret_cast<std::uint8_t*>(target.data));
}

InPlaceStatus JpegDecoder::decode(const char* name, std::span<const std::uint8_t> bytes, int format, int width,
                                  int height, int pitch_bytes, std::uint8_t* samples) {
  // Stop on warning: libjpeg fills the rest of a truncated image with gray and merely warns.
  constexpr int kFlags = TJFLAG_STOPONWARNING | TJFLAG_LIMITSCANS;
  const ForeignCall foreign;
  const auto length = static_cast<unsigned long>(bytes.size());
  int own_width = 0;
  int own_height = 0;
  int subsampling = 0;
  int colours = 0;
  if (tjDecompressHeader3(handle_.get(), bytes.data(), length, &own_width, &own_height, &subsampling, &colours) != 0) {
    return damaged(name, tjGetErrorStr2(handle_.get()));
  }
  if (own_width != width || own_height != height) {
    return size_error(name, own_width, own_height, width, height, "");
  }
  if (colours == TJCS_CMYK || colours == TJCS_YCCK) {
    return file_error(ErrorCode::kBadFormat, name, {"is a JPEG in CMYK, the colours of printing; convert it to RGB"});
  }
  const int code =
      tjDecompress2(handle_.get(), bytes.data(), length, samples, width, pitch_bytes, height, format, kFlags);
  if (code != 0 && !is_padding(tjGetErrorStr2(handle_.get()))) {
    return damaged(name, tjGetErrorStr2(handle_.get()));
  }
  return {};
}

}  // namespace kinetrace::imaging
