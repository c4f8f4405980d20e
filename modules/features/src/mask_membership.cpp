#include "mask_membership.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>

#include "kernel_types.hpp"

namespace kinetrace::features {
namespace {

// Part of the patch, on either side of the feature, that must be free of other objects.
constexpr float kClearPart = 0.7F;
// Of the four sides of a feature, at least this many must be the object's own.
constexpr std::ptrdiff_t kMinOwnSides = 2;

std::uint8_t nearest_label(LabelView labels, float x, float y) noexcept {
  return labels.at(std::clamp(static_cast<int>(std::lround(x)), 0, labels.width - 1),
                   std::clamp(static_cast<int>(std::lround(y)), 0, labels.height - 1));
}

/// Labels to the left, right, above and below, within the patch.
std::array<std::uint8_t, 4> labels_beside(LabelView labels, const Eigen::Vector2f& position_px) noexcept {
  constexpr float kX = kClearPart * kPatchHalfWidth;
  constexpr float kY = kClearPart * kPatchHalfHeight;
  return {nearest_label(labels, position_px.x() - kX, position_px.y()),
          nearest_label(labels, position_px.x() + kX, position_px.y()),
          nearest_label(labels, position_px.x(), position_px.y() - kY),
          nearest_label(labels, position_px.x(), position_px.y() + kY)};
}

// With fewer pixels of its own body, the whole patch is aligned.
constexpr int kMinOwnPixels = kPatchPixels / 4;
constexpr std::uint32_t kPatchColumns = (1U << kPatchWidth) - 1U;

/// Fast path: a patch and its border of one pixel lie in the image and all belong to the body.
bool all_own(LabelView labels, int left, int top, std::uint8_t body) noexcept {
  constexpr int kColumns = kPatchWidth + 2;
  constexpr int kRows = kPatchHeight + 2;
  if (left < 1 || top < 1 || left + kPatchWidth >= labels.width || top + kPatchHeight >= labels.height) {
    return false;
  }
  std::uint8_t difference = 0;
  for (int y = top - 1; y < top - 1 + kRows; ++y) {
    const std::uint8_t* const row = labels.row(y) + left - 1;
    for (int k = 0; k < kColumns; ++k) {
      difference |= static_cast<std::uint8_t>(row[k] ^ body);
    }
  }
  return difference == 0;
}

/// Bit k: pixel (x + k, y) is the body's own, and so are its neighbours to the left and right. kPatchWidth bits.
std::uint32_t own_row(LabelView labels, int x, int y, std::uint8_t body) noexcept {
  const std::uint8_t* const row = labels.row(std::clamp(y, 0, labels.height - 1));
  std::uint32_t own = 0;
  for (int k = -1; k <= kPatchWidth; ++k) {
    own |= (row[std::clamp(x + k, 0, labels.width - 1)] == body ? 1U : 0U) << (k + 1);
  }
  return own & (own >> 1) & (own >> 2);
}

}  // namespace

PatchMask own_pixels(LabelView labels, const Eigen::Vector2f& position_px, std::uint8_t body) noexcept {
  const int left = static_cast<int>(std::lround(position_px.x() - kPatchHalfWidth));
  const int top = static_cast<int>(std::lround(position_px.y() - kPatchHalfHeight));
  if (all_own(labels, left, top, body)) {
    return {{}, true};
  }
  std::array<std::uint32_t, kPatchHeight + 2> rows;
  for (int k = 0; k < kPatchHeight + 2; ++k) {
    rows[static_cast<std::size_t>(k)] = own_row(labels, left, top + k - 1, body);
  }
  PatchMask mask{{}, true};
  int count = 0;
  for (std::size_t k = 0; k < kPatchHeight; ++k) {
    const std::uint32_t own = rows[k] & rows[k + 1] & rows[k + 2] & kPatchColumns;
    mask.rows[k] = static_cast<std::uint16_t>(own);
    count += std::popcount(own);
    mask.whole = mask.whole && own == kPatchColumns;
  }
  mask.whole = mask.whole || count < kMinOwnPixels;
  return mask;
}

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
  return body == kBackgroundLabel || std::count(sides.begin(), sides.end(), body) >= kMinOwnSides;
}

}  // namespace kinetrace::features
