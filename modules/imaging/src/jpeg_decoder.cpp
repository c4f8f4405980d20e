#include "jpeg_decoder.hpp"

#include <string>

#include <turbojpeg.h>

#include "file_bytes.hpp"
#include "kinetrace/core/allocation_counter.hpp"

namespace kinetrace::imaging {

void ImageReader::JpegDecoderDelete::operator()(JpegDecoder* decoder) const noexcept {
  tjDestroy(decoder->handle);
  delete decoder;
}

std::unique_ptr<ImageReader::JpegDecoder, ImageReader::JpegDecoderDelete> ImageReader::JpegDecoder::create() {
  const tjhandle handle = tjInitDecompress();
  if (handle == nullptr) {
    return nullptr;
  }
  return std::unique_ptr<JpegDecoder, JpegDecoderDelete>(new JpegDecoder{handle});
}

Status ImageReader::JpegDecoder::decode_gray(const char* path, std::span<const std::uint8_t> bytes,
                                             MutableGrayView target) const {
  // Stop on warning: libjpeg fills the rest of a truncated image with gray and merely warns.
  constexpr int kFlags = TJFLAG_STOPONWARNING | TJFLAG_LIMITSCANS;
  int code = 0;
  {
    const ForeignCall foreign;
    code = tjDecompress2(handle, bytes.data(), static_cast<unsigned long>(bytes.size()), target.data, target.width,
                         target.stride, target.height, TJPF_GRAY, kFlags);
  }
  if (code != 0) {
    return file_error(ErrorCode::kBadFormat, path,
                      std::string("is damaged or truncated (JPEG decoder: ") + tjGetErrorStr2(handle) +
                          "); copy it again or remove it");
  }
  return {};
}

}  // namespace kinetrace::imaging
