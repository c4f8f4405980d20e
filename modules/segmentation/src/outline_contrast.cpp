#include "kinetrace/segmentation/outline_contrast.hpp"

#include <algorithm>
#include <array>
#include <cstdlib>

namespace kinetrace::segmentation {
namespace {

constexpr int kOutlineError_px = 3;  // Of usable masks.
// Beyond the error of an outline, yet mostly in its surroundings.
constexpr std::array<int, 4> kBeside_px{-24, -16, 16, 24};
constexpr int kMargin_px = 24 + kOutlineError_px + 2;

/// Largest difference between the two sides of column `x` and its neighbours.
int contrast_at(const std::uint8_t* row, int x) noexcept {
  int largest = 0;
  for (int column = x - kOutlineError_px; column <= x + kOutlineError_px; ++column) {
    largest = std::max(largest, std::abs(row[column + 2] - row[column - 1]));
  }
  return largest;
}

OutlineContrast contrast_of(const RectifiedPair& pair, LabelView labels, const Track& track) noexcept {
  OutlineContrast sum;
  const PixelBox& box = track.box_px;
  const std::uint8_t label = track.label();
  for (int y = std::max(box.y0, 0); y < std::min(box.y1, labels.height); ++y) {
    const std::uint8_t* mask = labels.row(y);
    const std::uint8_t* left = pair.left.row(y);
    const std::uint8_t* right = pair.right.row(y);
    for (int x = std::max(box.x0 - 1, kMargin_px); x < std::min(box.x1, labels.width - kMargin_px); ++x) {
      if ((mask[x] == label) == (mask[x + 1] == label)) {
        continue;
      }
      sum.points += 1.0;
      sum.left += contrast_at(left, x);
      sum.right += contrast_at(right, x);
      for (const int offset_px : kBeside_px) {
        sum.beside += contrast_at(left, x + offset_px) / static_cast<double>(kBeside_px.size());
      }
    }
  }
  return sum;
}

}  // namespace

OutlineContrast& OutlineContrast::operator+=(const OutlineContrast& other) noexcept {
  points += other.points;
  left += other.left;
  right += other.right;
  beside += other.beside;
  return *this;
}

OutlineContrast& OutlineContrast::operator*=(double weight) noexcept {
  points *= weight;
  left *= weight;
  right *= weight;
  beside *= weight;
  return *this;
}

OutlineContrast outline_contrast(const RectifiedPair& pair, LabelView left_labels,
                                 std::span<const Track> tracks) noexcept {
  OutlineContrast sum;
  for (const Track& track : tracks) {
    if (track.missed_frames == 0) {
      sum += contrast_of(pair, left_labels, track);
    }
  }
  return sum;
}

}  // namespace kinetrace::segmentation
