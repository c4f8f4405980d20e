#include "mask_membership.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "kernel_types.hpp"

namespace kinetrace::features {
namespace {

// Part of the patch on either side of the feature that must not be another object's.
constexpr float kClearPart = 0.7F;
// Of the four sides of a feature, so many must be the object's own.
constexpr std::ptrdiff_t kLeastOwnSides = 2;

std::uint8_t nearest_label(LabelView labels, float x, float y) noexcept {
  return labels.at(std::clamp(static_cast<int>(std::lround(x)), 0, labels.width - 1),
                   std::clamp(static_cast<int>(std::lround(y)), 0, labels.height - 1));
}

/// Left, right, above and below, within the patch.
std::array<std::uint8_t, 4> labels_beside(LabelView labels, const Eigen::Vector2f& position_px) noexcept {
  constexpr float kX = kClearPart * kPatchHalfWidth;
  constexpr float kY = kClearPart * kPatchHalfHeight;
  return {nearest_label(labels, position_px.x() - kX, position_px.y()),
          nearest_label(labels, position_px.x() + kX, position_px.y()),
          nearest_label(labels, position_px.x(), position_px.y() - kY),
          nearest_label(labels, position_px.x(), position_px.y() + kY)};
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

bool clear_of_other_objects(LabelView labels, const Eigen::Vector2f& position_px, std::uint8_t body) noexcept {
  const std::array<std::uint8_t, 4> sides = labels_beside(labels, position_px);
  return body == kBackgroundLabel || std::all_of(sides.begin(), sides.end(), [body](std::uint8_t label) {
           return label == body || label == kBackgroundLabel || label == kIgnoreLabel;
         });
}

bool well_inside(LabelView labels, const Eigen::Vector2f& position_px, std::uint8_t body) noexcept {
  const std::array<std::uint8_t, 4> sides = labels_beside(labels, position_px);
  return body == kBackgroundLabel || std::count(sides.begin(), sides.end(), body) >= kLeastOwnSides;
}

}  // namespace kinetrace::features
