#include "kinetrace/segmentation/mask_canvas.hpp"

#include <algorithm>

namespace kinetrace::segmentation {
namespace {

/// Sets the free pixels of a mask to the value.
void paint(const RunLengthMask& mask, std::uint16_t value, ImageView<std::uint16_t> image) noexcept {
  const auto width = static_cast<std::size_t>(mask.box_px.width());
  std::size_t at = 0;  // In the box, row by row.
  bool inside = false;
  for (const std::uint16_t run : mask.runs) {
    const std::size_t end = at + run;
    while (inside && at < end) {
      const std::size_t row_end = std::min(end, (at / width + 1) * width);
      std::uint16_t* row = image.row(mask.box_px.y0 + static_cast<int>(at / width)) + mask.box_px.x0;
      std::replace(row + at % width, row + at % width + (row_end - at), std::uint16_t{kBackgroundLabel}, value);
      at = row_end;
    }
    at = end;
    inside = !inside;
  }
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
    static_cast<void>(listed_.push_back({mask.class_id, mask.score}));
    paint(mask, static_cast<std::uint16_t>(listed_.size()), values_);
  }
  not_drawn_ = masks.size() - listed_.size();
}

int MaskCanvas::finish(const SegmentationConfig& config, InstanceRelabeler& relabeler) noexcept {
  return relabeler.relabel(values_, MaskEncoding::kListed, config.max_objects, config.min_area_px, labels_, detections_,
                           listed_.span()) +
         static_cast<int>(not_drawn_);
}

}  // namespace kinetrace::segmentation
