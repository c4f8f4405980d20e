#include "segmentation/picture_file.hpp"

#include <algorithm>
#include <array>
#include <string_view>
#include <system_error>
#include <utility>

namespace kinetrace::app {

Result<PictureFiles::Loaded> PictureFiles::read(const std::filesystem::path& path) {
  if (!reader_) {
    constexpr imaging::ImageReaderConfig kConfig{
        .max_width_px = kMaxSide_px, .max_height_px = kMaxSide_px, .max_file_bytes = std::size_t{64} << 20U};
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
  const std::size_t pixels = static_cast<std::size_t>(info->width) * static_cast<std::size_t>(info->height);
  gray_.resize(pixels);
  const MutableGrayView gray{gray_.data(), info->width, info->height, info->width};
  const Result<int> used_bits = reader_->used_bits(path.c_str());
  if (!used_bits) {
    return Unexpected(used_bits.error());
  }
  if (const Status read = reader_->read_gray(path.c_str(), gray, imaging::sample_bits_for(*used_bits)); !read) {
    return Unexpected(read.error());
  }
  if (info->channels < 3) {
    return Loaded{GrayView(gray), gray};
  }
  colours_.resize(pixels);
  if (const Status read = reader_->read_rgb(path.c_str(), {colours_.data(), info->width, info->height, info->width});
      !read) {
    return Unexpected(read.error());
  }
  const auto* samples = reinterpret_cast<const std::uint8_t*>(colours_.data());
  return Loaded{neural::Picture(samples, info->width, info->height, 3 * info->width, 3), gray};
}

Result<std::vector<std::filesystem::path>> picture_files(const std::vector<std::filesystem::path>& paths) {
  constexpr std::array<std::string_view, 4> kEndings{".png", ".jpg", ".jpeg", ".pgm"};
  std::vector<std::filesystem::path> files;
  for (const std::filesystem::path& path : paths) {
    std::error_code error;
    if (!std::filesystem::is_directory(path, error)) {
      files.push_back(path);
      continue;
    }
    const std::size_t first = files.size();
    for (const auto& entry : std::filesystem::directory_iterator(path, error)) {
      const std::string ending = entry.path().extension().string();
      if (std::find(kEndings.begin(), kEndings.end(), ending) != kEndings.end()) {
        files.push_back(entry.path());
      }
    }
    if (files.size() == first) {
      return fail(ErrorCode::kNotFound, path.string() + ": holds no .png, .jpg or .pgm files");
    }
    std::sort(files.begin() + static_cast<std::ptrdiff_t>(first), files.end());
  }
  return files;
}

}  // namespace kinetrace::app
