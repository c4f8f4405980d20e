// Counting and rewriting labels of label images.
#pragma once

#include <array>
#include <cstdint>

#include "kinetrace/core/image_view.hpp"

namespace kinetrace::tracking {

/// A value for each of the 256 labels.
using LabelTable = std::array<std::uint8_t, 256>;

/// One predicted mask and how many of its pixels fall on each detection.
struct PredictionOverlap {
  PixelBox box_px;
  int area_px = 0;
  std::array<int, 256> on_label{};  ///< Pixels shared with each label of the other image.
};

/// Counts the pixels of `region` that have `label` in `prediction`, by their label in `detections` (which may be empty:
/// no overlaps).
void measure_overlap(LabelView prediction, std::uint8_t label, const PixelBox& region, LabelView detections,
                     PredictionOverlap& overlap) noexcept;

/// Pixels in both over pixels in either; 0 when both are empty.
[[nodiscard]] double intersection_over_union(int intersection_px, int area_px, int other_area_px) noexcept;

/// target = table[source], pixel by pixel. Both images have the same size.
void relabel(LabelView source, const LabelTable& table, MutableLabelView target) noexcept;

/// Extent of a label.
struct LabelRegion {
  PixelBox box_px;
  int area_px = 0;
};

/// Gives `label` to the background pixels of `target` in `region` that have it in `prediction`; returns their extent.
LabelRegion assign_free_pixels(LabelView prediction, std::uint8_t label, const PixelBox& region,
                               MutableLabelView target) noexcept;

/// All pixels of the image become background.
void clear_labels(MutableLabelView labels) noexcept;

}  // namespace kinetrace::tracking
