#include "capture/luminance_reader.hpp"

#include <optional>
#include <utility>

#include "capture/image_layout.hpp"
#include "kinetrace/imaging/jpeg_decoder.hpp"
#include "util/messages.hpp"

namespace kinetrace::hal {
namespace {

bool needs_no_conversion(PixelFormat format) {
  return bytes_per_pixel(format) == 1;
}

MutableGrayView carve(const CaptureConfig& config, Arena& arena) {
  return needs_no_conversion(config.format) ? MutableGrayView{}
                                            : take_image<std::uint8_t>(arena, config.width_px, config.height_px);
}

const std::uint8_t* row_of(const CapturedImage& image, const CaptureInfo& info, int y) {
  return reinterpret_cast<const std::uint8_t*>(image.data.data()) + static_cast<std::ptrdiff_t>(y) * info.stride_bytes;
}

/// Calls luminance(first byte of a pixel) for every pixel.
template <typename Luminance>
void convert(const CapturedImage& image, const CaptureInfo& info, MutableGrayView target, Luminance luminance) {
  for (int y = 0; y < target.height; ++y) {
    const std::uint8_t* source = row_of(image, info, y);
    std::uint8_t* row = target.row(y);
    for (int x = 0; x < target.width; ++x) {
      row[x] = luminance(source + 2 * static_cast<std::ptrdiff_t>(x));
    }
  }
}

// Little-endian 16-bit samples with kBits used low bits: converts the upper 8 of these, saturated.
template <int kBits>
void convert_samples(const CapturedImage& image, const CaptureInfo& info, MutableGrayView target) {
  convert(image, info, target, [](const std::uint8_t* bytes) {
    constexpr unsigned kWhite = 255;
    const unsigned sample = (static_cast<unsigned>(bytes[1]) << 8U) | bytes[0];
    return static_cast<std::uint8_t>(std::min(sample >> static_cast<unsigned>(kBits - 8), kWhite));
  });
}

}  // namespace

struct LuminanceReader::Impl {
  PixelFormat format;
  MutableGrayView converted{};  ///< Empty where luminance lies in place.
  std::optional<imaging::JpegDecoder> jpeg{};

  [[nodiscard]] Status check(const CapturedImage& image, const CaptureInfo& info) const;
  [[nodiscard]] Status decode(const CapturedImage& image, const CaptureInfo& info);
};

LuminanceReader::LuminanceReader(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
LuminanceReader::LuminanceReader(LuminanceReader&&) noexcept = default;
LuminanceReader& LuminanceReader::operator=(LuminanceReader&&) noexcept = default;
LuminanceReader::~LuminanceReader() = default;

std::size_t LuminanceReader::required_bytes(const CaptureConfig& config) {
  return measure_bytes([&config](Arena& arena) { carve(config, arena); });
}

Result<LuminanceReader> LuminanceReader::create(const CaptureConfig& config, Arena& arena) {
  auto impl = std::make_unique<Impl>(Impl{.format = config.format, .converted = carve(config, arena)});
  if (arena.exhausted()) {
    return fail(ErrorCode::kCapacity, concat("the arena does not hold the ", std::to_string(required_bytes(config)),
                                             " bytes of a converted image; enlarge the memory budget"));
  }
  if (config.format == PixelFormat::kMjpeg) {
    auto decoder = imaging::JpegDecoder::create();
    if (!decoder) {
      return Unexpected(decoder.error());
    }
    impl->jpeg = std::move(*decoder);
  }
  return LuminanceReader(std::move(impl));
}

// Drivers are not trusted: a view beyond the bytes would be read out of bounds later.
Status LuminanceReader::Impl::check(const CapturedImage& image, const CaptureInfo& info) const {
  const bool fits_reader =
      needs_no_conversion(format) || (info.width_px == converted.width && info.height_px == converted.height);
  if (info.format != format || info.width_px < 1 || info.height_px < 1 || !fits_reader ||
      info.stride_bytes < bytes_per_pixel(format) * info.width_px) {
    return fail(ErrorCode::kBadFormat,
                concat(info.name, ": delivers ", to_string(info.format), " ", size_text(info.width_px, info.height_px),
                       " with rows of ", std::to_string(info.stride_bytes), " bytes, which is not what was set"));
  }
  if (image.data.size() < bytes_needed(info)) {
    return fail(ErrorCode::kBadFormat, concat(info.name, ": an image of ", std::to_string(image.data.size()),
                                              " bytes is too short; check cable and bandwidth"));
  }
  return {};
}

Status LuminanceReader::Impl::decode(const CapturedImage& image, const CaptureInfo& info) {
  const std::span bytes(reinterpret_cast<const std::uint8_t*>(image.data.data()), image.data.size());
  Status decoded = jpeg->decode_gray(info.name.c_str(), bytes, converted);
  if (!decoded) {
    decoded.error().code = ErrorCode::kBadFormat;  // An unannounced size is damage, too.
  }
  return decoded;
}

Result<GrayView> LuminanceReader::read(const CapturedImage& image, const CaptureInfo& info) {
  if (const Status sound = impl_->check(image, info); !sound) {
    return Unexpected(sound.error());
  }
  switch (impl_->format) {
    case PixelFormat::kGrey8:
    case PixelFormat::kNv12: return GrayView{row_of(image, info, 0), info.width_px, info.height_px, info.stride_bytes};
    case PixelFormat::kGrey10: convert_samples<10>(image, info, impl_->converted); break;
    case PixelFormat::kGrey16: convert_samples<16>(image, info, impl_->converted); break;
    case PixelFormat::kYuyv:
      convert(image, info, impl_->converted, [](const std::uint8_t* bytes) { return bytes[0]; });
      break;
    case PixelFormat::kMjpeg:
      if (const Status decoded = impl_->decode(image, info); !decoded) {
        return Unexpected(decoded.error());
      }
      break;
  }
  return impl_->converted;
}

}  // namespace kinetrace::hal
