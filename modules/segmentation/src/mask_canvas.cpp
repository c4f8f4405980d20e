#include "kinetrace/segmentation/mask_canvas.hpp"

#include <algorithm>
#include <array>
#include <numeric>

namespace kinetrace::segmentation {
namespace {

/// Calls visit(begin, end) for each run of pixels of the mask in one row of the image.
template <typename Visit>
void for_each_run(const RunLengthMask& mask, ImageView<std::uint16_t> image, Visit&& visit) noexcept {
  const auto width = static_cast<std::size_t>(mask.box_px.width());
  std::size_t at = 0;  // In the box, row by row.
  bool inside = false;
  for (const std::uint16_t run : mask.runs) {
    const std::size_t end = at + run;
    while (inside && at < end) {
      const std::size_t row_end = std::min(end, (at / width + 1) * width);
      std::uint16_t* const row = image.row(mask.box_px.y0 + static_cast<int>(at / width)) + mask.box_px.x0;
      visit(row + at % width, row + at % width + (row_end - at));
      at = row_end;
    }
    at = end;
    inside = !inside;
  }
}

bool may_be_same_class(std::uint16_t a, std::uint16_t b) noexcept {
  return a != kIgnoreClass && b != kIgnoreClass && (a == b || a == kUnknownClass || b == kUnknownClass);
}

/// What the masks before it, drawn as 1, 2, ..., have of a mask.
struct Overlap {
  bool is_duplicate = false;                ///< Those of its class have more than half of it.
  std::uint16_t behind = kBackgroundLabel;  ///< The one of another class that has more than half of it.
};

Overlap overlap_with(std::span<const RunLengthMask> before, const RunLengthMask& mask,
                     ImageView<std::uint16_t> image) noexcept {
  std::array<std::uint32_t, MaskCanvas::kMaxMasks + 1> pixels{};
  for_each_run(mask, image, [&](const std::uint16_t* begin, const std::uint16_t* end) {
    std::for_each(begin, end, [&](std::uint16_t value) { ++pixels[value]; });
  });
  const std::uint32_t all = std::accumulate(pixels.begin(), pixels.end(), 0U);
  std::uint32_t of_its_class = 0;
  Overlap overlap;
  for (std::size_t k = 0; k < before.size(); ++k) {
    if (may_be_same_class(before[k].class_id, mask.class_id)) {
      of_its_class += pixels[k + 1];
    } else if (2 * pixels[k + 1] > all && before[k].class_id != kIgnoreClass && mask.class_id != kIgnoreClass) {
      overlap.behind = static_cast<std::uint16_t>(k + 1);
    }
  }
  overlap.is_duplicate = 2 * of_its_class > all;
  return overlap;
}

}  // namespace

MaskCanvas::MaskCanvas(const StereoGeometry& geometry, int max_objects, Arena& arena)
    : values_(take_image<std::uint16_t>(arena, geometry.width_px, geometry.height_px)),
      labels_(take_image<std::uint8_t>(arena, geometry.width_px, geometry.height_px)),
      detections_(arena, static_cast<std::size_t>(max_objects)),
      listed_(arena, kMaxMasks) {}

template <typename OverlapOf>
void MaskCanvas::draw_with(std::span<const RunLengthMask> masks, const OverlapOf& overlap_of) noexcept {
  for (int y = 0; y < values_.height; ++y) {
    std::fill_n(values_.row(y), values_.width, std::uint16_t{kBackgroundLabel});
  }
  listed_.clear();
  for (const RunLengthMask& mask : masks.first(std::min(masks.size(), listed_.capacity()))) {
    const Overlap overlap = overlap_of(masks.first(listed_.size()), mask);
    static_cast<void>(listed_.push_back({overlap.is_duplicate ? kIgnoreClass : mask.class_id, mask.score}));
    const auto value = static_cast<std::uint16_t>(listed_.size());
    for_each_run(mask, values_, [&](std::uint16_t* begin, std::uint16_t* end) {
      std::replace(begin, end, std::uint16_t{kBackgroundLabel}, value);
      std::replace(begin, end, overlap.behind, value);
    });
  }
  not_drawn_ = masks.size() - listed_.size();
}

void MaskCanvas::draw(std::span<const RunLengthMask> masks) noexcept {
  draw_with(masks, [](std::span<const RunLengthMask>, const RunLengthMask&) { return Overlap{}; });
}

void MaskCanvas::draw_candidates(std::span<const RunLengthMask> masks) noexcept {
  draw_with(masks, [this](std::span<const RunLengthMask> before, const RunLengthMask& mask) {
    return overlap_with(before, mask, values_);
  });
}

int MaskCanvas::finish(const SegmentationConfig& config, InstanceRelabeler& relabeler) noexcept {
  return relabeler.relabel(values_, MaskEncoding::kListed, config.max_objects, config.min_area_px, labels_, detections_,
                           listed_.span()) +
         static_cast<int>(not_drawn_);
}

}  // namespace kinetrace::segmentation
