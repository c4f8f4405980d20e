#include "study/gray16_images.hpp"

#include <utility>

namespace kinetrace::app {

Result<ImageView<const std::uint16_t>> Gray16Images::read(const std::filesystem::path& path) {
  if (!reader_) {
    constexpr imaging::ImageReaderConfig kConfig{.max_width_px = 8192, .max_height_px = 8192};
    arena_.emplace(imaging::ImageReader::required_bytes(kConfig));
    Result<imaging::ImageReader> reader = imaging::ImageReader::create(kConfig, *arena_);
    if (!reader) {
      return Unexpected(reader.error());
    }
    reader_ = std::move(*reader);
  }
  const Result<imaging::ImageInfo> info = reader_->inspect(path.c_str());
  if (!info) {
    return Unexpected(info.error());
  }
  pixels_.resize(static_cast<std::size_t>(info->width) * static_cast<std::size_t>(info->height));
  const ImageView<std::uint16_t> image{pixels_.data(), info->width, info->height, info->width};
  if (const Status read = reader_->read_gray16(path.c_str(), image); !read) {
    return Unexpected(read.error());
  }
  bit_depth_ = info->bit_depth;
  return image;
}

}  // namespace kinetrace::app
