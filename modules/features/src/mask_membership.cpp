#include "mask_membership.hpp"

#include <algorithm>
#include <cmath>

namespace kinetrace::features {

bool still_member(LabelView labels, const Eigen::Vector2f& position_px, std::uint8_t body, float border_px) noexcept {
  const auto label_at = [&](float x, float y) {
    return labels.at(std::clamp(static_cast<int>(std::lround(x)), 0, labels.width - 1),
                     std::clamp(static_cast<int>(std::lround(y)), 0, labels.height - 1));
  };
  const std::uint8_t here = label_at(position_px.x(), position_px.y());
  if (here == kIgnoreLabel) {
    return false;
  }
  for (int dy = -1; dy <= 1; ++dy) {
    for (int dx = -1; dx <= 1; ++dx) {
      if (label_at(position_px.x() + static_cast<float>(dx) * border_px,
                   position_px.y() + static_cast<float>(dy) * border_px) == body) {
        return true;
      }
    }
  }
  return false;
}

}  // namespace kinetrace::features
