#include "mask_membership.hpp"

#include <algorithm>
#include <cmath>

#include "kernel_types.hpp"

namespace kinetrace::features {
namespace {

// Part of the patch on either side of the feature that must not be another object's.
constexpr float kClearPart = 0.7F;
// Of the four sides of a feature, so many must be the object's own.
constexpr int kLeastOwnSides = 2;

std::uint8_t nearest_label(LabelView labels, float x, float y) noexcept {
  return labels.at(std::clamp(static_cast<int>(std::lround(x)), 0, labels.width - 1),
                   std::clamp(static_cast<int>(std::lround(y)), 0, labels.height - 1));
}

}  // namespace

bool still_member(LabelView labels, const Eigen::Vector2f& position_px, std::uint8_t body, float border_px) noexcept {
  const std::uint8_t here = nearest_label(labels, position_px.x(), position_px.y());
  if (here == kIgnoreLabel) {
    return false;
  }
  for (int dy = -1; dy <= 1; ++dy) {
    for (int dx = -1; dx <= 1; ++dx) {
      if (nearest_label(labels, position_px.x() + static_cast<float>(dx) * border_px,
                        position_px.y() + static_cast<float>(dy) * border_px) == body) {
        return true;
      }
    }
  }
  return false;
}

bool well_inside(LabelView labels, const Eigen::Vector2f& position_px, std::uint8_t body) noexcept {
  const auto other = [&](float dx, float dy) {
    const std::uint8_t label = nearest_label(labels, position_px.x() + dx, position_px.y() + dy);
    return label != body && label != kBackgroundLabel && label != kIgnoreLabel;
  };
  constexpr float kX = kClearPart * kPatchHalfWidth;
  constexpr float kY = kClearPart * kPatchHalfHeight;
  const auto own = [&](float dx, float dy) {
    return nearest_label(labels, position_px.x() + dx, position_px.y() + dy) == body ? 1 : 0;
  };
  return body == kBackgroundLabel || (own(-kX, 0.F) + own(kX, 0.F) + own(0.F, -kY) + own(0.F, kY) >= kLeastOwnSides &&
                                      !(other(-kX, 0.F) || other(kX, 0.F) || other(0.F, -kY) || other(0.F, kY)));
}

}  // namespace kinetrace::features
