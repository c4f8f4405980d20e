// Non-owning views of images.
#pragma once

#include <algorithm>
#include <cassert>
#include <cstddef>
#include <cstdint>
#include <span>
#include <type_traits>

#include "kinetrace/core/arena.hpp"

namespace kinetrace {

/// A rectangle of pixels, rows `stride` elements apart. Pixel centres lie at integer coordinates; x right, y down.
template <typename T>
struct ImageView {
  T* data = nullptr;
  int width = 0;
  int height = 0;
  int stride = 0;  ///< Elements from one row to the next, >= width.

  [[nodiscard]] bool empty() const noexcept { return data == nullptr || width <= 0 || height <= 0; }
  [[nodiscard]] T* row(int y) const noexcept {
    assert(y >= 0 && y < height);
    return data + static_cast<std::ptrdiff_t>(y) * stride;
  }
  [[nodiscard]] T& at(int x, int y) const noexcept {
    assert(x >= 0 && x < width);
    return row(y)[x];
  }
  [[nodiscard]] bool contains(int x, int y) const noexcept { return x >= 0 && y >= 0 && x < width && y < height; }

  /// A view of mutable pixels is also a view of constant ones.
  operator ImageView<const T>() const noexcept  // NOLINT(google-explicit-constructor)
      requires(!std::is_const_v<T>) {
    return {data, width, height, stride};
  }
};

using GrayView = ImageView<const std::uint8_t>;    ///< 8-bit luminance.
using MutableGrayView = ImageView<std::uint8_t>;   ///< 8-bit luminance, writable.
using LabelView = ImageView<const std::uint8_t>;   ///< Per pixel: see kBackgroundLabel, kIgnoreLabel.
using MutableLabelView = ImageView<std::uint8_t>;  ///< The same, writable.

inline constexpr std::uint8_t kBackgroundLabel = 0;  ///< No instance here.
inline constexpr std::uint8_t kIgnoreLabel = 255;    ///< Neither background nor object: no features, no evaluation.
inline constexpr int kMaxObjects = 64;               ///< Labels 1..kMaxObjects are instances.

/// Carves an image from an arena, rows padded to `kRowAlignment` elements.
inline constexpr int kRowAlignment = 32;
template <typename T>
[[nodiscard]] ImageView<T> take_image(Arena& arena, int width, int height) {
  const int stride = (width + kRowAlignment - 1) / kRowAlignment * kRowAlignment;
  const std::span<T> pixels = arena.take<T>(static_cast<std::size_t>(stride) * static_cast<std::size_t>(height));
  return {pixels.data(), width, height, stride};
}

/// Copies `source` into `target`; both have the same size.
template <typename T>
void copy_image(ImageView<const T> source, ImageView<T> target) noexcept {
  assert(source.width == target.width && source.height == target.height);
  for (int y = 0; y < source.height; ++y) {
    std::copy_n(source.row(y), source.width, target.row(y));
  }
}

/// Axis-aligned pixel rectangle, half open: x in [x0, x1), y in [y0, y1).
struct PixelBox {
  int x0 = 0;
  int y0 = 0;
  int x1 = 0;
  int y1 = 0;
  [[nodiscard]] int width() const noexcept { return x1 - x0; }
  [[nodiscard]] int height() const noexcept { return y1 - y0; }
  [[nodiscard]] bool empty() const noexcept { return x1 <= x0 || y1 <= y0; }
  /// Of its pixels' centres.
  [[nodiscard]] double center_x() const noexcept { return 0.5 * (x0 + x1 - 1); }
  [[nodiscard]] double center_y() const noexcept { return 0.5 * (y0 + y1 - 1); }
  /// Reaches the border of an image of this size, or beyond.
  [[nodiscard]] bool touches_border(int image_width, int image_height) const noexcept {
    return x0 <= 0 || y0 <= 0 || x1 >= image_width || y1 >= image_height;
  }
  /// Grows to hold pixel (x, y); an empty box becomes just that pixel.
  void include(int x, int y) noexcept {
    if (empty()) {
      *this = {x, y, x + 1, y + 1};
      return;
    }
    x0 = std::min(x0, x);
    y0 = std::min(y0, y);
    x1 = std::max(x1, x + 1);
    y1 = std::max(y1, y + 1);
  }
};

}  // namespace kinetrace
