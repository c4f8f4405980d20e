#include "encode_for_test.hpp"

#include <cstdlib>
#include <fstream>
#include <stdexcept>

#include <spng.h>
#include <turbojpeg.h>

namespace kinetrace::imaging::test {
namespace {

Bytes encode_jpeg(int width, int height, const Bytes& pixels, int format, int subsampling) {
  const tjhandle handle = tjInitCompress();
  unsigned char* data = nullptr;
  unsigned long size = 0;
  const int code = tjCompress2(handle, pixels.data(), width, 0, height, format, &data, &size, subsampling, 100, 0);
  Bytes bytes(data, data + (code == 0 ? size : 0));
  tjFree(data);
  tjDestroy(handle);
  return bytes;
}

}  // namespace

Bytes encode_png(const PngKind& kind, int width, int height, const Bytes& pixels) {
  spng_ctx* context = spng_ctx_new(SPNG_CTX_ENCODER);
  spng_set_option(context, SPNG_ENCODE_TO_BUFFER, 1);
  spng_ihdr header{};
  header.width = static_cast<std::uint32_t>(width);
  header.height = static_cast<std::uint32_t>(height);
  header.bit_depth = kind.bit_depth;
  header.color_type = kind.color_type;
  header.interlace_method = kind.interlaced ? 1 : 0;
  spng_set_ihdr(context, &header);
  if (kind.color_type == SPNG_COLOR_TYPE_INDEXED) {
    spng_plte palette{};
    palette.n_entries = 1U << kind.bit_depth;
    for (std::uint32_t i = 0; i < palette.n_entries; ++i) {
      palette.entries[i] = {static_cast<std::uint8_t>(i), static_cast<std::uint8_t>(2 * i),
                            static_cast<std::uint8_t>(255 - i), 255};
    }
    spng_set_plte(context, &palette);
  }
  const int code = spng_encode_image(context, pixels.data(), pixels.size(), SPNG_FMT_PNG, SPNG_ENCODE_FINALIZE);
  if (code != 0) {
    throw std::runtime_error(spng_strerror(code));
  }
  std::size_t size = 0;
  int error = 0;
  void* data = spng_get_png_buffer(context, &size, &error);
  const auto* first = static_cast<const std::uint8_t*>(data);
  Bytes bytes(first, first + size);
  std::free(data);
  spng_ctx_free(context);
  return bytes;
}

Bytes encode_jpeg_gray(int width, int height, const Bytes& pixels) {
  return encode_jpeg(width, height, pixels, TJPF_GRAY, TJSAMP_GRAY);
}
Bytes encode_jpeg_rgb(int width, int height, const Bytes& pixels) {
  return encode_jpeg(width, height, pixels, TJPF_RGB, TJSAMP_444);
}
Bytes encode_jpeg_cmyk(int width, int height, const Bytes& pixels) {
  return encode_jpeg(width, height, pixels, TJPF_CMYK, TJSAMP_444);
}

void write_file(const std::string& path, const Bytes& bytes) {
  std::ofstream(path, std::ios::binary)
      .write(reinterpret_cast<const char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
}

}  // namespace kinetrace::imaging::test
