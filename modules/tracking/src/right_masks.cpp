// The part of StereoTracker that maps left tracks to the right image.
#include <algorithm>
#include <cmath>

#include "kinetrace/tracking/stereo_tracker.hpp"

namespace kinetrace::tracking {

std::span<const DisparitySample> StereoTracker::gather_samples(LabelView labels, std::uint8_t label,
                                                               std::span<const Feature> features) noexcept {
  std::size_t n = 0;
  for (const Feature& f : features) {
    const int x = static_cast<int>(std::lround(f.left_px.x()));
    const int y = static_cast<int>(std::lround(f.left_px.y()));
    if (f.has_right() && n < samples_.size() && labels.contains(x, y) && labels.at(x, y) == label) {
      samples_[n++] = {f.left_px, f.disparity_px()};
    }
  }
  return samples_.first(n);
}

void StereoTracker::attach_right(const DetectionFrame& detections, std::span<const Feature> features) {
  for (TrackInstance& instance : slots_) {
    if (instance.alive()) {
      update_disparity(instance, features);
    }
  }
  clear_labels(prediction_);
  sort_far_to_near();
  for (const std::uint8_t slot : far_to_near_) {
    draw_right_prediction(slots_[slot]);
  }
  associate_right(detections);
}

void StereoTracker::update_disparity(TrackInstance& instance, std::span<const Feature> features) {
  const DisparityPlane seen = fit_disparity(gather_samples(left_, instance.track.label(), features), scratch_);
  if (seen.known) {
    instance.disparity = seen;
  } else if (instance.disparity.known) {  // an old slope need not hold for a mask that has moved since
    instance.disparity.slope.setZero();
    instance.disparity.min_px = instance.disparity.max_px = instance.disparity.mean_px;
  }
}

// P_{i+1,lr}: for each right pixel the left one that the disparity plane maps to it, x = x_right + d(x, y).
void StereoTracker::draw_right_prediction(TrackInstance& instance) noexcept {
  const DisparityPlane& d = instance.disparity;
  const PixelBox& left_box = instance.track.box_px;
  instance.right_region_px = {};
  if (!d.known || left_box.empty()) {
    return;
  }
  PixelBox region = left_box;
  region.x0 = std::clamp(left_box.x0 - static_cast<int>(std::ceil(d.max_px)) - 1, 0, width_px_);
  region.x1 = std::clamp(left_box.x1 - static_cast<int>(std::floor(d.min_px)) + 1, 0, width_px_);
  if (region.empty()) {
    return;
  }
  const std::uint8_t label = instance.track.label();
  const float gain = 1.F / (1.F - d.slope.x());
  for (int y = region.y0; y < region.y1; ++y) {
    const float row_disparity_px =
        d.mean_px + d.slope.y() * (static_cast<float>(y) - d.center_px.y()) - d.slope.x() * d.center_px.x();
    const std::uint8_t* source = left_.row(y);
    std::uint8_t* target = prediction_.row(y);
    for (int x = region.x0; x < region.x1; ++x) {
      const float unclamped_px = (row_disparity_px + d.slope.x() * static_cast<float>(x)) * gain;
      const float disparity_px = std::clamp(unclamped_px, d.min_px, d.max_px);
      const int left_x = x + static_cast<int>(2.F * disparity_px + 1.F) / 2;  // rounds half up: it is not negative
      if (left_x >= 0 && left_x < width_px_ && source[left_x] == label) {
        target[x] = label;
      }
    }
  }
  instance.right_region_px = region;
}

void StereoTracker::associate_right(const DetectionFrame& detections) noexcept {
  const bool have_masks = detections.available && !detections.right_labels.empty();
  const LabelView labels = have_masks ? detections.right_labels : LabelView{};
  const std::size_t columns = have_masks ? detections.right.size() : 0;
  affinity_.resize(static_cast<int>(slots_.size()), static_cast<int>(columns));
  for (TrackInstance& instance : slots_) {
    if (!instance.alive()) {
      continue;
    }
    PredictionOverlap overlap;
    measure_overlap(prediction_, instance.track.label(), instance.right_region_px, labels, overlap);
    instance.right_region_px = overlap.box_px;
    instance.right_visible_fraction = instance.disparity.known && instance.predicted_px > 0
                                          ? static_cast<double>(overlap.area_px) / instance.predicted_px
                                          : 1.0;
    for (std::size_t v = 0; v < columns; ++v) {
      const Detection& detection = detections.right[v];
      const double fit = intersection_over_union(overlap.on_label[detection.label], overlap.area_px, detection.area_px);
      const bool is_match = fit >= config_.min_overlap && classes_agree(instance.track.class_id, detection.class_id);
      affinity_(instance.track.slot, static_cast<int>(v)) = is_match ? fit : 0.0;
    }
  }
  const Assignment match = maximum_weight_assignment(affinity_);

  LabelTable table;
  table.fill(kIgnoreLabel);
  table[kBackgroundLabel] = kBackgroundLabel;
  for (const TrackInstance& instance : slots_) {
    if (instance.alive() && match[instance.track.slot] >= 0) {
      table[detections.right[static_cast<std::size_t>(match[instance.track.slot])].label] = instance.track.label();
    }
  }
  if (have_masks) {
    relabel(labels, table, right_);
  } else {
    clear_labels(right_);
  }
  for (const TrackInstance& instance : slots_) {
    if (instance.alive() && match[instance.track.slot] < 0) {
      assign_free_pixels(prediction_, instance.track.label(), instance.right_region_px, right_);
    }
  }
}

}  // namespace kinetrace::tracking
