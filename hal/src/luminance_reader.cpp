#include "luminance_reader.hpp"

#include "messages.hpp"

namespace kinetrace::hal {

struct LuminanceReader::Impl {};

LuminanceReader::LuminanceReader(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
LuminanceReader::LuminanceReader(LuminanceReader&&) noexcept = default;
LuminanceReader& LuminanceReader::operator=(LuminanceReader&&) noexcept = default;
LuminanceReader::~LuminanceReader() = default;

std::size_t LuminanceReader::required_bytes(const CaptureConfig& /*config*/) {
  return 0;
}

Result<LuminanceReader> LuminanceReader::create(const CaptureConfig& config, Arena& /*arena*/) {
  if (config.format != PixelFormat::kGrey8 && config.format != PixelFormat::kNv12) {
    return fail(ErrorCode::kUnsupported, config.device + ": this pixel format is not part of this build");
  }
  return LuminanceReader(std::make_unique<Impl>());
}

Result<GrayView> LuminanceReader::read(const CapturedImage& image, const CaptureInfo& info) {
  const auto stride = static_cast<std::size_t>(info.stride_bytes);
  const std::size_t needed =
      stride * static_cast<std::size_t>(info.height_px - 1) + static_cast<std::size_t>(info.width_px);
  if (image.data.size() < needed) {
    return fail(ErrorCode::kBadFormat, concat(info.name, ": an image of ", std::to_string(image.data.size()),
                                              " bytes is too short; check cable and bandwidth"));
  }
  return GrayView{reinterpret_cast<const std::uint8_t*>(image.data.data()), info.width_px, info.height_px,
                  info.stride_bytes};
}

}  // namespace kinetrace::hal
