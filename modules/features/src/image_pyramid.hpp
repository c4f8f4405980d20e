// One image at full, half, quarter... size, shared by all users of the frame.
#pragma once

#include <array>
#include <span>

#include "kernel_types.hpp"
#include "kinetrace/core/arena.hpp"
#include "kinetrace/core/image_view.hpp"

namespace kinetrace::features {

inline constexpr int kMaxPyramidLevels = 6;

/// An 8-bit image inside replicated padding.
class PaddedImage {
 public:
  PaddedImage() = default;
  PaddedImage(Arena& arena, int width, int height);

  [[nodiscard]] MutableGrayView pixels() const noexcept { return pixels_; }
  [[nodiscard]] Plane plane() const noexcept;
  /// Repeats the outermost pixels into the padding.
  void pad() noexcept;

 private:
  MutableGrayView pixels_;
};

/// Full size is level 0. Pixel (x, y) of level l is centred on full-size (2^l (x + .5) - .5, ...).
class ImagePyramid {
 public:
  ImagePyramid() = default;
  ImagePyramid(Arena& arena, int width, int height, int levels);

  /// `scratch` holds at least the width + 4 elements.
  void build(GrayView image, std::span<std::uint16_t> scratch) noexcept;

  [[nodiscard]] int levels() const noexcept { return levels_; }
  [[nodiscard]] Plane level(int index) const noexcept { return images_[static_cast<std::size_t>(index)].plane(); }

  /// Number of levels, at most `wanted`, whose smallest side has at least 16 pixels.
  [[nodiscard]] static int supported_levels(int width, int height, int wanted) noexcept;

 private:
  std::array<PaddedImage, kMaxPyramidLevels> images_;
  int levels_ = 0;
};

/// A full-size coordinate at `level`, and back.
[[nodiscard]] inline float to_level(float full, int level) noexcept {
  return (full + 0.5F) / static_cast<float>(1 << level) - 0.5F;
}
[[nodiscard]] inline float from_level(float coordinate, int level) noexcept {
  return (coordinate + 0.5F) * static_cast<float>(1 << level) - 0.5F;
}

}  // namespace kinetrace::features
