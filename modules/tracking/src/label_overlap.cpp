#include "kinetrace/tracking/label_overlap.hpp"

#include <algorithm>
#include <cstring>

namespace kinetrace::tracking {

namespace {

/// Masks are mostly runs of one label: eight equal pixels are handled at a time.
constexpr int kStep = 8;

std::uint64_t eight_pixels(const std::uint8_t* pixels) noexcept {
  std::uint64_t eight = 0;
  std::memcpy(&eight, pixels, sizeof eight);
  return eight;
}

constexpr std::uint64_t eight_of(std::uint8_t label) noexcept {
  return 0x0101010101010101U * label;
}

}  // namespace

void measure_overlap(LabelView prediction, std::uint8_t label, const PixelBox& region, LabelView detections,
                     PredictionOverlap& overlap) noexcept {
  overlap = {};
  for (int y = region.y0; y < region.y1; ++y) {
    const std::uint8_t* predicted = prediction.row(y);
    const std::uint8_t* detected = detections.empty() ? nullptr : detections.row(y);
    int first = -1;
    int last = -1;
    const auto count = [&](int x, int pixels, std::uint8_t on) {
      first = first < 0 ? x : first;
      last = x + pixels - 1;
      overlap.area_px += pixels;
      overlap.on_label[on] += detected != nullptr ? pixels : 0;
    };
    int x = region.x0;
    while (x < region.x1) {
      const std::uint8_t on = detected != nullptr ? detected[x] : kBackgroundLabel;
      if (x + kStep <= region.x1) {
        const std::uint64_t eight = eight_pixels(predicted + x);
        if (eight == eight_of(label) && (detected == nullptr || eight_pixels(detected + x) == eight_of(on))) {
          count(x, kStep, on);
          x += kStep;
          continue;
        }
        if (eight == 0) {
          x += kStep;
          continue;
        }
      }
      if (predicted[x] == label) {
        count(x, 1, on);
      }
      ++x;
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
  for (int y = 0; y < source.height; ++y) {
    const std::uint8_t* from = source.row(y);
    std::uint8_t* to = target.row(y);
    int x = 0;
    for (; x + kStep <= source.width; x += kStep) {
      if (eight_pixels(from + x) == eight_of(from[x])) {
        std::fill_n(to + x, kStep, table[from[x]]);
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

LabelRegion assign_free_pixels(LabelView prediction, std::uint8_t label, const PixelBox& region,
                               MutableLabelView target) noexcept {
  LabelRegion claimed;
  for (int y = region.y0; y < region.y1; ++y) {
    const std::uint8_t* predicted = prediction.row(y);
    std::uint8_t* shown = target.row(y);
    int first = -1;
    int last = -1;
    const auto take = [&](int x, int pixels) {
      std::fill_n(shown + x, pixels, label);
      first = first < 0 ? x : first;
      last = x + pixels - 1;
      claimed.area_px += pixels;
    };
    int x = region.x0;
    while (x < region.x1) {
      if (x + kStep <= region.x1 && eight_pixels(predicted + x) == eight_of(label) && eight_pixels(shown + x) == 0) {
        take(x, kStep);
        x += kStep;
        continue;
      }
      if (predicted[x] == label && shown[x] == kBackgroundLabel) {
        take(x, 1);
      }
      ++x;
    }
    if (first >= 0) {
      claimed.box_px.include(first, y);
      claimed.box_px.include(last, y);
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
