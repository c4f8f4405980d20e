#include "kinetrace/tracking/label_overlap.hpp"

#include <algorithm>
#include <cstring>

namespace kinetrace::tracking {

void measure_overlap(LabelView prediction, std::uint8_t label, const PixelBox& region, LabelView detections,
                     PredictionOverlap& overlap) noexcept {
  overlap = {};
  for (int y = region.y0; y < region.y1; ++y) {
    const std::uint8_t* predicted = prediction.row(y);
    const std::uint8_t* detected = detections.empty() ? nullptr : detections.row(y);
    int first = -1;
    int last = -1;
    for (int x = region.x0; x < region.x1; ++x) {
      if (predicted[x] != label) {
        continue;
      }
      first = first < 0 ? x : first;
      last = x;
      ++overlap.area_px;
      if (detected != nullptr) {
        ++overlap.on_label[detected[x]];
      }
    }
    if (first >= 0) {
      overlap.box_px.include(first, y);
      overlap.box_px.include(last, y);
    }
  }
}

double intersection_over_union(int intersection_px, int area_px, int other_area_px) noexcept {
  const int either = area_px + other_area_px - intersection_px;
  return either > 0 ? static_cast<double>(intersection_px) / either : 0.0;
}

void relabel(LabelView source, const LabelTable& table, MutableLabelView target) noexcept {
  constexpr int kStep = 8;  // Most of an image is background: eight pixels are skipped at a time.
  for (int y = 0; y < source.height; ++y) {
    const std::uint8_t* from = source.row(y);
    std::uint8_t* to = target.row(y);
    int x = 0;
    for (; x + kStep <= source.width; x += kStep) {
      std::uint64_t eight = 0;
      std::memcpy(&eight, from + x, sizeof eight);
      if (eight == 0) {
        std::fill_n(to + x, kStep, table[kBackgroundLabel]);
        continue;
      }
      for (int i = x; i < x + kStep; ++i) {
        to[i] = table[from[i]];
      }
    }
    for (; x < source.width; ++x) {
      to[x] = table[from[x]];
    }
  }
}

LabelRegion claim_free_pixels(LabelView prediction, std::uint8_t label, const PixelBox& region,
                              MutableLabelView target) noexcept {
  LabelRegion claimed;
  for (int y = region.y0; y < region.y1; ++y) {
    const std::uint8_t* predicted = prediction.row(y);
    std::uint8_t* shown = target.row(y);
    for (int x = region.x0; x < region.x1; ++x) {
      if (predicted[x] == label && shown[x] == kBackgroundLabel) {
        shown[x] = label;
        claimed.box_px.include(x, y);
        ++claimed.area_px;
      }
    }
  }
  return claimed;
}

void clear_labels(MutableLabelView labels) noexcept {
  for (int y = 0; y < labels.height; ++y) {
    std::fill_n(labels.row(y), labels.width, kBackgroundLabel);
  }
}

}  // namespace kinetrace::tracking
