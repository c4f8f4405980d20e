#include "kinetrace/segmentation/mask_canvas.hpp"

#include <algorithm>
#include <array>

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

/// The drawn value that most pixels of the mask have, if more than half of them have it; else background.
std::uint16_t prevailing_value(const RunLengthMask& mask, ImageView<std::uint16_t> image) noexcept {
  std::array<std::uint32_t, MaskCanvas::kMaxMasks + 1> pixels{};
  std::uint32_t all = 0;
  for_each_run(mask, image, [&](const std::uint16_t* begin, const std::uint16_t* end) {
    std::for_each(begin, end, [&](std::uint16_t value) { ++pixels[value]; });
    all += static_cast<std::uint32_t>(end - begin);
  });
  const auto most = std::max_element(pixels.begin(), pixels.end());
  return 2 * *most > all ? static_cast<std::uint16_t>(most - pixels.begin()) : std::uint16_t{kBackgroundLabel};
}

enum class Place : std::uint8_t { kBehind, kInFront, kDuplicate };

/// Place of a mask relative to an earlier one that has most of its pixels.
Place place_on(std::uint16_t earlier_class, const RunLengthMask& mask) noexcept {
  if (earlier_class == kIgnoreClass || mask.class_id == kIgnoreClass) {
    return Place::kBehind;
  }
  const bool may_be_same =
      earlier_class == mask.class_id || earlier_class == kUnknownClass || mask.class_id == kUnknownClass;
  return may_be_same ? Place::kDuplicate : Place::kInFront;
}

}  // namespace

MaskCanvas::MaskCanvas(const StereoGeometry& geometry, int max_objects, Arena& arena)
    : values_(take_image<std::uint16_t>(arena, geometry.width_px, geometry.height_px)),
      labels_(take_image<std::uint8_t>(arena, geometry.width_px, geometry.height_px)),
      detections_(arena, static_cast<std::size_t>(max_objects)),
      listed_(arena, kMaxMasks) {}

void MaskCanvas::draw(std::span<const RunLengthMask> masks) noexcept {
  for (int y = 0; y < values_.height; ++y) {
    std::fill_n(values_.row(y), values_.width, std::uint16_t{kBackgroundLabel});
  }
  listed_.clear();
  for (const RunLengthMask& mask : masks.first(std::min(masks.size(), listed_.capacity()))) {
    const std::uint16_t owner = prevailing_value(mask, values_);
    const Place place = owner == kBackgroundLabel ? Place::kBehind : place_on(listed_[owner - 1U].class_id, mask);
    const std::uint16_t covered = place == Place::kInFront ? owner : std::uint16_t{kBackgroundLabel};
    static_cast<void>(listed_.push_back({place == Place::kDuplicate ? kIgnoreClass : mask.class_id, mask.score}));
    const auto value = static_cast<std::uint16_t>(listed_.size());
    for_each_run(mask, values_, [&](std::uint16_t* begin, std::uint16_t* end) {
      std::replace_if(
          begin, end, [covered](std::uint16_t drawn) { return drawn == kBackgroundLabel || drawn == covered; }, value);
    });
  }
  not_drawn_ = masks.size() - listed_.size();
}

int MaskCanvas::finish(const SegmentationConfig& config, InstanceRelabeler& relabeler) noexcept {
  return relabeler.relabel(values_, MaskEncoding::kListed, config.max_objects, config.min_area_px, labels_, detections_,
                           listed_.span()) +
         static_cast<int>(not_drawn_);
}

}  // namespace kinetrace::segmentation
