#include "feature_slot.hpp"

#include <cmath>
#include <cstring>

namespace kinetrace::features {

void ReferencePatch::take(const Plane& image, float x, float y) noexcept {
  // The sample positions of an unwarped patch are half a pixel off its centre in x.
  const int left = static_cast<int>(std::floor(x)) - (kWidth / 2 - 1);
  const int top = static_cast<int>(std::floor(y + 0.5F)) - kHeight / 2;
  for (int row = 0; row < kHeight; ++row) {
    const std::ptrdiff_t offset = static_cast<std::ptrdiff_t>(top + row) * image.stride + left;
    std::memcpy(pixels_.data() + static_cast<std::ptrdiff_t>(row) * kWidth, image.data + offset, kWidth);
  }
  x_ = x - static_cast<float>(left);
  y_ = y - static_cast<float>(top);
}

}  // namespace kinetrace::features
