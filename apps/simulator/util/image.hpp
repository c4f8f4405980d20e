// An image that owns its pixels.
#pragma once

#include <cstddef>
#include <vector>

#include "kinetrace/core/image_view.hpp"

namespace kinetrace::simulator {

template <typename T>
class Image {
 public:
  Image() = default;
  Image(int width, int height, T value = T{})
      : width_(width),
        height_(height),
        pixels_(static_cast<std::size_t>(width) * static_cast<std::size_t>(height), value) {}

  [[nodiscard]] int width() const noexcept { return width_; }
  [[nodiscard]] int height() const noexcept { return height_; }
  [[nodiscard]] bool contains(int x, int y) const noexcept { return x >= 0 && y >= 0 && x < width_ && y < height_; }
  [[nodiscard]] T& at(int x, int y) noexcept { return pixels_[index(x, y)]; }
  [[nodiscard]] const T& at(int x, int y) const noexcept { return pixels_[index(x, y)]; }
  [[nodiscard]] std::vector<T>& pixels() noexcept { return pixels_; }
  [[nodiscard]] const std::vector<T>& pixels() const noexcept { return pixels_; }
  [[nodiscard]] ImageView<const T> view() const noexcept { return {pixels_.data(), width_, height_, width_}; }

 private:
  [[nodiscard]] std::size_t index(int x, int y) const noexcept {
    return static_cast<std::size_t>(y) * static_cast<std::size_t>(width_) + static_cast<std::size_t>(x);
  }
  int width_ = 0;
  int height_ = 0;
  std::vector<T> pixels_;
};

}  // namespace kinetrace::simulator
