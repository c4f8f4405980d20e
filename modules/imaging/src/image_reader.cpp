#include "kinetrace/imaging/image_reader.hpp"

#include <string>

#include "image_file.hpp"
#include "pgm_decoder.hpp"
#include "png_decoder.hpp"

namespace kinetrace::imaging {

Status ImageReaderConfig::validate() const {
  static_assert(kMaxImageSide_px == 16384);
  constexpr std::size_t kMinFile = 1024;
  constexpr std::size_t kMaxFile = std::size_t{1} << 30;
  if (max_width_px < 1 || max_width_px > kMaxImageSide_px) {
    return fail(ErrorCode::kInvalidConfig,
                "image_reader.max_width_px must be in [1, 16384], got " + std::to_string(max_width_px));
  }
  if (max_height_px < 1 || max_height_px > kMaxImageSide_px) {
    return fail(ErrorCode::kInvalidConfig,
                "image_reader.max_height_px must be in [1, 16384], got " + std::to_string(max_height_px));
  }
  if (max_file_bytes < kMinFile || max_file_bytes > kMaxFile) {
    return fail(ErrorCode::kInvalidConfig,
                "image_reader.max_file_bytes must be in [1024, 1073741824], got " + std::to_string(max_file_bytes));
  }
  return {};
}

void ImageReader::carve(const ImageReaderConfig& config, Arena& arena, Storage& storage) {
  storage.file = arena.take<std::uint8_t>(config.max_file_bytes);
  storage.row = arena.take<std::uint8_t>(static_cast<std::size_t>(config.max_width_px) * kPngRowBytesPerPixel);
}

std::size_t ImageReader::required_bytes(const ImageReaderConfig& config) {
  return measure_bytes([&config](Arena& arena) {
    Storage storage;
    carve(config, arena, storage);
  });
}

Result<ImageReader> ImageReader::create(const ImageReaderConfig& config, Arena& arena) {
  if (const Status valid = config.validate(); !valid) {
    return Unexpected(valid.error());
  }
  auto jpeg = JpegDecoder::create();
  if (!jpeg) {
    return Unexpected(jpeg.error());
  }
  ImageReader reader(std::move(*jpeg));
  reader.config_ = config;
  carve(config, arena, reader.storage_);
  if (arena.exhausted()) {
    return fail(ErrorCode::kCapacity, "the arena does not hold the image reader's " +
                                          std::to_string(required_bytes(config)) + " bytes; enlarge the memory budget");
  }
  return reader;
}

InPlaceResult<ImageInfo> ImageReader::inspect(const char* path) const {
  return read_image_info(path).and_then([&](const ImageInfo& info) { return within_limits(path, info); });
}

InPlaceResult<ImageInfo> ImageReader::within_limits(const char* path, const ImageInfo& info) const {
  if (info.width > config_.max_width_px || info.height > config_.max_height_px) {
    return file_error(
        ErrorCode::kBadFormat, path,
        {"is ", NumberText(info.width), "x", NumberText(info.height), " pixels, at most ",
         NumberText(config_.max_width_px), "x", NumberText(config_.max_height_px), " are read here; scale it down"});
  }
  return info;
}

InPlaceResult<std::span<const std::uint8_t>> ImageReader::load(const char* path, int width, int height,
                                                               ImageInfo& info) {
  const InPlaceResult<ImageInfo> header = read_image_info(path);
  if (!header) {
    return Unexpected(header.error());
  }
  info = *header;
  if (info.width != width || info.height != height) {
    return size_error(path, info.width, info.height, width, height, "; all images of a sequence must have one size");
  }
  if (const auto readable = within_limits(path, info); !readable) {
    return Unexpected(readable.error());
  }
  const InPlaceResult<InputFile> file = open_image(path);
  if (!file) {
    return Unexpected(file.error());
  }
  if (file->size_bytes() > storage_.file.size()) {
    return file_error(ErrorCode::kBadFormat, path,
                      {"has ", NumberText(file->size_bytes()), " bytes, at most ", NumberText(storage_.file.size()),
                       " are read of an image here; compress it"});
  }
  const std::size_t got = file->read(0, storage_.file.first(file->size_bytes()));
  if (got < file->size_bytes()) {
    return file_error(ErrorCode::kIo, path, {"could not be read to its end; check the storage device"});
  }
  return storage_.file.first(got);
}

InPlaceStatus ImageReader::read_gray(const char* path, MutableGrayView target, int sample_bits) {
  ImageInfo info;
  const auto bytes = load(path, target.width, target.height, info);
  if (!bytes) {
    return Unexpected(bytes.error());
  }
  switch (info.format) {
    case ImageFormat::kPng: return decode_png_gray(path, *bytes, info, storage_.row, target, sample_bits);
    case ImageFormat::kPgm: return decode_pgm_gray(path, *bytes, target, sample_bits);
    case ImageFormat::kJpeg: return jpeg_.decode_gray(path, *bytes, target);
  }
  return {};
}

InPlaceResult<int> ImageReader::used_bits(const char* path) {
  const InPlaceResult<ImageInfo> header = inspect(path);
  if (!header) {
    return Unexpected(header.error());
  }
  if (header->bit_depth < 16 || header->channels > 2) {
    return 16;
  }
  ImageInfo info;
  const auto bytes = load(path, header->width, header->height, info);
  if (!bytes) {
    return Unexpected(bytes.error());
  }
  return info.format == ImageFormat::kPng ? used_bits_of_png(path, *bytes, info, storage_.row)
                                          : used_bits_of_pgm(path, *bytes, info);
}

InPlaceStatus ImageReader::read_rgb(const char* path, ImageView<Rgb8> target) {
  ImageInfo info;
  const auto bytes = load(path, target.width, target.height, info);
  if (!bytes) {
    return Unexpected(bytes.error());
  }
  switch (info.format) {
    case ImageFormat::kPng: return decode_png_rgb(path, *bytes, storage_.row, target);
    case ImageFormat::kJpeg: return jpeg_.decode_rgb(path, *bytes, target);
    case ImageFormat::kPgm: break;
  }
  return file_error(ErrorCode::kUnsupported, path, {"is a PGM, which has no colours"});
}

InPlaceStatus ImageReader::read_gray16(const char* path, ImageView<std::uint16_t> target) {
  ImageInfo info;
  const auto bytes = load(path, target.width, target.height, info);
  if (!bytes) {
    return Unexpected(bytes.error());
  }
  switch (info.format) {
    case ImageFormat::kPng: return decode_png_gray16(path, *bytes, info, storage_.row, target);
    case ImageFormat::kPgm: return decode_pgm_gray16(path, *bytes, target);
    case ImageFormat::kJpeg: break;
  }
  return file_error(ErrorCode::kUnsupported, path, {"is a JPEG; label images must be gray PNG or PGM"});
}

}  // namespace kinetrace::imaging
