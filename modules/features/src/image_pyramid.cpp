#include "image_pyramid.hpp"

#include <algorithm>
#include <cstring>

#include "kernels.hpp"

namespace kinetrace::features {

PaddedImage::PaddedImage(Arena& arena, int width, int height) {
  const MutableGrayView padded = take_image<std::uint8_t>(arena, width + 2 * kPadding, height + 2 * kPadding);
  // A measuring arena gives no memory to point into.
  std::uint8_t* const origin = padded.empty() ? nullptr : padded.row(kPadding) + kPadding;
  pixels_ = {origin, width, height, padded.stride};
}

Plane PaddedImage::plane() const noexcept {
  // Interpolation reads one pixel further than the position asked for.
  return {pixels_.data, pixels_.width, pixels_.height, pixels_.stride, kPadding - 2};
}

void PaddedImage::pad() noexcept {
  const auto padding = static_cast<std::size_t>(kPadding);
  const auto row_bytes = static_cast<std::size_t>(pixels_.width) + 2 * padding;
  for (int y = 0; y < pixels_.height; ++y) {
    std::uint8_t* const row = pixels_.row(y);
    std::memset(row - kPadding, row[0], padding);
    std::memset(row + pixels_.width, row[pixels_.width - 1], padding);
  }
  const std::uint8_t* const first = pixels_.row(0) - kPadding;
  const std::uint8_t* const last = pixels_.row(pixels_.height - 1) - kPadding;
  for (std::ptrdiff_t i = 1; i <= kPadding; ++i) {
    std::memcpy(pixels_.data - kPadding - i * pixels_.stride, first, row_bytes);
    std::memcpy(pixels_.data - kPadding + (pixels_.height - 1 + i) * pixels_.stride, last, row_bytes);
  }
}

ImagePyramid::ImagePyramid(Arena& arena, int width, int height, int levels)
    : levels_(supported_levels(width, height, levels)) {
  for (int i = 0; i < levels_; ++i) {
    images_[static_cast<std::size_t>(i)] = PaddedImage(arena, width >> i, height >> i);
  }
}

void ImagePyramid::build(GrayView image, std::span<std::uint16_t> scratch) noexcept {
  copy_image(image, images_[0].pixels());
  images_[0].pad();
  for (int i = 1; i < levels_; ++i) {
    PaddedImage& target = images_[static_cast<std::size_t>(i)];
    const MutableGrayView pixels = target.pixels();
    kernels().pyramid.downsample(level(i - 1), pixels.data, pixels.width, pixels.height, pixels.stride, scratch.data());
    target.pad();
  }
}

int ImagePyramid::supported_levels(int width, int height, int wanted) noexcept {
  constexpr int kMinSide = 16;
  int levels = 1;
  while (levels < std::min(wanted, kMaxPyramidLevels) && (std::min(width, height) >> levels) >= kMinSide) {
    ++levels;
  }
  return levels;
}

}  // namespace kinetrace::features
