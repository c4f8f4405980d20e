#include "pgm_decoder.hpp"

#include <algorithm>
#include <bit>

#include "image_file.hpp"

namespace kinetrace::imaging {
namespace {

constexpr std::uint32_t kMaxByte = 255;
constexpr std::uint32_t kMaxSample = 65535;

bool is_space(std::uint8_t c) {
  return c == ' ' || (c >= '\t' && c <= '\r');
}

// The next decimal number, after white space and comments; false at the end of the data or on anything else.
bool next_number(std::span<const std::uint8_t> bytes, std::size_t& at, std::uint32_t& value) {
  while (at < bytes.size() && (is_space(bytes[at]) || bytes[at] == '#')) {
    if (bytes[at] == '#') {
      at = static_cast<std::size_t>(
          std::find(bytes.begin() + static_cast<std::ptrdiff_t>(at), bytes.end(), std::uint8_t{'\n'}) - bytes.begin());
    } else {
      ++at;
    }
  }
  const std::size_t first = at;
  value = 0;
  while (at < bytes.size() && bytes[at] >= '0' && bytes[at] <= '9' && at - first < 9) {
    value = value * 10 + (bytes[at] - '0');
    ++at;
  }
  return at > first && at < bytes.size();
}

std::size_t bytes_per_sample(const PgmHeader& header) {
  return header.max_value > kMaxByte ? 2 : 1;
}

/// The header of a file that has all its pixels.
InPlaceResult<PgmHeader> parse_whole(const char* path, std::span<const std::uint8_t> bytes, int width, int height) {
  InPlaceResult<PgmHeader> header = parse_pgm_header(path, bytes);
  if (!header) {
    return header;
  }
  const std::size_t row_bytes = static_cast<std::size_t>(width) * bytes_per_sample(*header);
  if ((bytes.size() - header->pixels_offset) / row_bytes < static_cast<std::size_t>(height)) {
    return file_error(ErrorCode::kBadFormat, path, {"is truncated: fewer pixels than its header says; copy it again"});
  }
  return header;
}

// Calls write(x, y, value) for every sample.
template <typename Write>
InPlaceStatus for_each_sample(const char* path, std::span<const std::uint8_t> bytes, int width, int height,
                              Write&& write) {
  const InPlaceResult<PgmHeader> header = parse_whole(path, bytes, width, height);
  if (!header) {
    return Unexpected(header.error());
  }
  const std::size_t sample_bytes = bytes_per_sample(*header);
  const std::uint8_t* sample = bytes.data() + header->pixels_offset;
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x, sample += sample_bytes) {
      const std::uint32_t value =
          sample_bytes == 1 ? sample[0] : static_cast<std::uint32_t>(sample[0] << 8 | sample[1]);
      write(x, y, std::min(value, header->max_value), header->max_value);
    }
  }
  return {};
}

}  // namespace

InPlaceResult<PgmHeader> parse_pgm_header(const char* path, std::span<const std::uint8_t> bytes) {
  PgmHeader header;
  std::size_t at = 2;
  const bool complete = next_number(bytes, at, header.width) && next_number(bytes, at, header.height) &&
                        next_number(bytes, at, header.max_value);
  if (!complete || !is_space(bytes[at]) || header.max_value == 0 || header.max_value > kMaxSample) {
    return file_error(ErrorCode::kBadFormat, path, {"has a damaged PGM header; expected P5, width, height, maxval"});
  }
  header.pixels_offset = at + 1;
  return header;
}

InPlaceStatus decode_pgm_gray(const char* path, std::span<const std::uint8_t> bytes, MutableGrayView target,
                              int sample_bits) {
  const InPlaceResult<PgmHeader> header = parse_whole(path, bytes, target.width, target.height);
  if (header && header->max_value == kMaxByte) {
    copy_image(GrayView{bytes.data() + header->pixels_offset, target.width, target.height, target.width}, target);
    return {};
  }
  return for_each_sample(path, bytes, target.width, target.height,
                         [target, sample_bits](int x, int y, std::uint32_t value, std::uint32_t max_value) {
                           target.at(x, y) =
                               max_value == kMaxSample
                                   ? upper_bits(value, sample_bits)
                                   : static_cast<std::uint8_t>((value * kMaxByte + max_value / 2) / max_value);
                         });
}

InPlaceResult<int> used_bits_of_pgm(const char* path, std::span<const std::uint8_t> bytes, const ImageInfo& info) {
  std::uint32_t all = 0;
  const InPlaceStatus read = for_each_sample(
      path, bytes, info.width, info.height, [&all](int /*x*/, int /*y*/, std::uint32_t value, std::uint32_t max_value) {
        all |= max_value == kMaxSample ? value : kMaxSample;  // Another maxval defines white.
      });
  return read ? InPlaceResult<int>(std::bit_width(all)) : Unexpected(read.error());
}

InPlaceStatus decode_pgm_gray16(const char* path, std::span<const std::uint8_t> bytes,
                                ImageView<std::uint16_t> target) {
  return for_each_sample(path, bytes, target.width, target.height,
                         [target](int x, int y, std::uint32_t value, std::uint32_t /*max_value*/) {
                           target.at(x, y) = static_cast<std::uint16_t>(value);
                         });
}

}  // namespace kinetrace::imaging
