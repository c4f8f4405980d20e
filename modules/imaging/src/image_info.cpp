#include "kinetrace/imaging/image_info.hpp"

#include <algorithm>
#include <array>
#include <cstddef>
#include <span>

#include "exif_orientation.hpp"
#include "image_file.hpp"
#include "pgm_decoder.hpp"

namespace kinetrace::imaging {
namespace {

// Deflate packs at most 1032 bytes into one (zlib's technical details); the codings of JPEG need at least a bit for a
// block of 64 samples. So the length of the file bounds the size in its header, before memory is taken.
constexpr std::uint64_t kMaxCompression = 1032;

std::uint32_t big_endian(const std::uint8_t* bytes, int count) {
  std::uint32_t value = 0;
  for (int i = 0; i < count; ++i) {
    value = value << 8 | bytes[i];
  }
  return value;
}

Unexpected<InPlaceError> truncated(const char* path) {
  return file_error(ErrorCode::kBadFormat, path, {"ends within its header; copy it again or remove it"});
}

// Size as stated in a header, unchecked.
struct Claim {
  std::uint32_t width = 0;
  std::uint32_t height = 0;
  std::uint32_t bits_per_pixel = 8;
};

InPlaceResult<ImageInfo> checked_size(const char* path, const InputFile& file, ImageInfo info, const Claim& claim) {
  const auto claims = [&](const char* what) {
    return file_error(
        ErrorCode::kBadFormat, path,
        {"its header claims ", NumberText(claim.width), "x", NumberText(claim.height), " pixels, ", what});
  };
  if (claim.width == 0 || claim.height == 0 || claim.width > kMaxImageSide_px || claim.height > kMaxImageSide_px) {
    static_assert(kMaxImageSide_px == 16384);
    return claims("which is not within 1 to 16384 each way; the file is damaged, or the image has to be scaled down");
  }
  const std::uint64_t row_bytes = (std::uint64_t{claim.width} * claim.bits_per_pixel + 7) / 8;
  if (row_bytes * claim.height > kMaxCompression * file.size_bytes()) {
    return claims("which its few bytes cannot hold; the file is damaged, copy it again or remove it");
  }
  info.width = static_cast<int>(claim.width);
  info.height = static_cast<int>(claim.height);
  return info;
}

// PNG specification, 11.2.2: IHDR is the first chunk, at a fixed place.
InPlaceResult<ImageInfo> png_info(const char* path, const InputFile& file, std::span<const std::uint8_t> head) {
  constexpr std::size_t kHeaderBytes = 26;
  if (head.size() < kHeaderBytes) {
    return truncated(path);
  }
  ImageInfo info;
  info.format = ImageFormat::kPng;
  info.bit_depth = head[24];
  switch (head[25]) {
    case 0: info.channels = 1; break;
    case 2:
    case 3: info.channels = 3; break;
    case 4: info.channels = 2; break;
    case 6: info.channels = 4; break;
    default: return file_error(ErrorCode::kBadFormat, path, {"has an invalid PNG colour type; the file is damaged"});
  }
  constexpr int kPalette = 3;
  const int samples = head[25] == kPalette ? 1 : info.channels;
  return checked_size(path, file, info,
                      {big_endian(&head[16], 4), big_endian(&head[20], 4),
                       static_cast<std::uint32_t>(samples) * static_cast<std::uint32_t>(info.bit_depth)});
}

// JPEG (ITU T.81, B.1.1): walk the marker segments up to the start of frame, which holds the size.
InPlaceResult<ImageInfo> jpeg_info(const char* path, const InputFile& file) {
  constexpr int kApplication1 = 0xE1;
  std::size_t offset = 2;
  std::array<std::uint8_t, 10> segment{};
  while (file.read(offset, segment) == segment.size()) {
    const int marker = segment[1];
    if (segment[0] != 0xFF) {
      break;
    }
    if (marker == 0xFF) {  // Fill byte.
      ++offset;
      continue;
    }
    const bool start_of_frame = marker >= 0xC0 && marker <= 0xCF && marker != 0xC4 && marker != 0xC8 && marker != 0xCC;
    if (start_of_frame) {
      ImageInfo info;
      info.format = ImageFormat::kJpeg;
      info.bit_depth = segment[4];
      info.channels = segment[9];
      return checked_size(path, file, info, {big_endian(&segment[7], 2), big_endian(&segment[5], 2)});
    }
    if (marker == 0xD9 || marker == 0xDA) {  // End of image, start of scan: no frame came before.
      break;
    }
    const std::size_t length = big_endian(&segment[2], 2);
    if (marker == kApplication1 && length > 2 && exif_orientation(file, offset + 4, length - 2) != kExifUpright) {
      return file_error(
          ErrorCode::kUnsupported, path,
          {"is turned or mirrored by its Exif orientation, which not every program heeds; turn its pixels "
           "(exiftran -a -i), or remove the tag if it was calibrated as stored (exiftool -Orientation=)"});
    }
    offset += 2 + length;
  }
  return truncated(path);
}

InPlaceResult<ImageInfo> pgm_info(const char* path, const InputFile& file, std::span<const std::uint8_t> head) {
  const InPlaceResult<PgmHeader> header = parse_pgm_header(path, head);
  if (!header) {
    return Unexpected(header.error());
  }
  ImageInfo info;
  info.format = ImageFormat::kPgm;
  info.channels = 1;
  info.bit_depth = header->max_value > 255 ? 16 : 8;
  return checked_size(path, file, info, {header->width, header->height, static_cast<std::uint32_t>(info.bit_depth)});
}

}  // namespace

InPlaceResult<ImageInfo> read_image_info(const char* path) {
  const InPlaceResult<InputFile> file = open_image(path);
  if (!file) {
    return Unexpected(file.error());
  }
  std::array<std::uint8_t, 1024> buffer{};
  const std::span<const std::uint8_t> head(buffer.data(), file->read(0, buffer));
  constexpr std::array<std::uint8_t, 8> kPngMagic{0x89, 'P', 'N', 'G', '\r', '\n', 0x1A, '\n'};
  const auto begins_with = [&head](std::span<const std::uint8_t> magic) {
    return head.size() >= magic.size() && std::equal(magic.begin(), magic.end(), head.begin());
  };
  if (begins_with(kPngMagic)) {
    return png_info(path, *file, head);
  }
  if (head.size() >= 3 && head[0] == 0xFF && head[1] == 0xD8 && head[2] == 0xFF) {
    return jpeg_info(path, *file);
  }
  if (head.size() >= 2 && head[0] == 'P' && head[1] == '5') {
    return pgm_info(path, *file, head);
  }
  if (head.size() < kPngMagic.size() && std::equal(head.begin(), head.end(), kPngMagic.begin())) {
    return truncated(path);
  }
  return file_error(ErrorCode::kUnsupported, path, {"is no PNG, JPEG or binary PGM image; convert it to PNG"});
}

bool is_png(const char* path, int channels, int bit_depth) {
  const InPlaceResult<ImageInfo> info = read_image_info(path);
  return info && info->format == ImageFormat::kPng && info->channels == channels && info->bit_depth == bit_depth;
}

bool is_drawn_picture(const std::filesystem::path& path) {
  return is_png(path.c_str(), 3, 8);
}

}  // namespace kinetrace::imaging
