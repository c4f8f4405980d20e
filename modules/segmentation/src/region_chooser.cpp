#include "kinetrace/segmentation/region_chooser.hpp"

#include <algorithm>
#include <cstddef>
#include <cstdlib>

namespace kinetrace::segmentation {
namespace {

constexpr int kZoom = 2;
// Margin around a track, for its motion since, and so that the border does not cut it.
constexpr int kMargin_px = 8;
constexpr int kMarginPartOfSize = 8;

int margin(int size_px) noexcept {
  return kMargin_px + size_px / kMarginPartOfSize;
}

int distance_between_centres(const PixelBox& a, const PixelBox& b) noexcept {
  return std::abs(a.x0 + a.x1 - b.x0 - b.x1) + std::abs(a.y0 + a.y1 - b.y0 - b.y1);
}

}  // namespace

RegionChooser::RegionChooser(const StereoGeometry& geometry) noexcept
    : image_width_px_(geometry.width_px),
      image_height_px_(geometry.height_px),
      width_px_(std::max(1, geometry.width_px / kZoom)),
      height_px_(std::max(1, geometry.height_px / kZoom)) {}

RegionChooser::Range RegionChooser::around(const PixelBox& box) const noexcept {
  const int dx = margin(box.width());
  const int dy = margin(box.height());
  return {.x0 = std::clamp(std::min(box.x1 + dx, image_width_px_) - width_px_, 0, image_width_px_ - width_px_),
          .y0 = std::clamp(std::min(box.y1 + dy, image_height_px_) - height_px_, 0, image_height_px_ - height_px_),
          .x1 = std::min(std::max(box.x0 - dx, 0), image_width_px_ - width_px_),
          .y1 = std::min(std::max(box.y0 - dy, 0), image_height_px_ - height_px_)};
}

RegionChooser::Range RegionChooser::common_part(const Range& a, const Range& b) noexcept {
  return {std::max(a.x0, b.x0), std::max(a.y0, b.y0), std::min(a.x1, b.x1), std::min(a.y1, b.y1)};
}

std::uint64_t RegionChooser::last_region(const Track& track) const noexcept {
  const Look& look = looks_[track.slot];
  return look.track_id == track.id ? look.region : 0;
}

const Track* RegionChooser::waiting_longest(std::span<const Track> tracks) const noexcept {
  const Track* longest = nullptr;
  for (const Track& track : tracks) {
    const bool fits = !track.box_px.empty() && !around(track.box_px).empty();
    if (fits && (longest == nullptr || last_region(track) < last_region(*longest))) {
      longest = &track;
    }
  }
  return longest;
}

PixelBox RegionChooser::choose(std::span<const Track> tracks) noexcept {
  const Track* first = waiting_longest(tracks);
  if (first == nullptr) {
    return {};
  }
  ++regions_;
  Range range = around(first->box_px);
  std::array<const Track*, kMaxObjects> others{};
  std::size_t count = 0;
  for (const Track& track : tracks) {
    if (!track.box_px.empty()) {
      others[count++] = &track;
    }
  }
  std::sort(others.begin(), others.begin() + count, [&](const Track* a, const Track* b) {
    const int to_a = distance_between_centres(a->box_px, first->box_px);
    const int to_b = distance_between_centres(b->box_px, first->box_px);
    return to_a != to_b ? to_a < to_b : a->id < b->id;
  });
  for (std::size_t i = 0; i < count; ++i) {
    const Range narrower = common_part(range, around(others[i]->box_px));
    if (!narrower.empty()) {
      range = narrower;
      looks_[others[i]->slot] = {others[i]->id, regions_};
    }
  }
  const int x = (range.x0 + range.x1) / 2;
  const int y = (range.y0 + range.y1) / 2;
  return {x, y, x + width_px_, y + height_px_};
}

void RegionChooser::reset() noexcept {
  looks_ = {};
}

}  // namespace kinetrace::segmentation
