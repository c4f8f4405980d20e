// The part of StereoTracker that predicts masks and their occlusion order.
#include <algorithm>
#include <array>
#include <bit>
#include <cmath>

#include "expectations.hpp"
#include "kinetrace/core/quantiles.hpp"
#include "kinetrace/tracking/stereo_tracker.hpp"

namespace kinetrace::tracking {
namespace {

/// Position for masks of objects behind the camera or too near.
constexpr double kFarOutsidePx = 1e6;
/// Features measure the change of scale to .3 px over their spread times the root of their number: at this bound as
/// much as the nearest small objects grow from frame to frame. Less certain ones must not accumulate in an occluded
/// mask, which no detection corrects.
constexpr double kMinScaleSupport_px = 60.0;
/// Fewer occluded pixels may be the noise of masks.
constexpr int kMinOccludedPx = 24;
/// Side of the blocks of pixels that a box hides or not: its sides are not better known.
constexpr int kBlock_px = 4;
/// The front object occludes this many times more of the other than vice versa.
constexpr int kOcclusionRatio = 3;

std::uint64_t slot_bit(const TrackInstance& instance) noexcept {
  return std::uint64_t{1} << instance.track.slot;
}

}  // namespace

void StereoTracker::predict(std::span<const Feature> features) {
  for (TrackInstance& instance : slots_) {
    if (!instance.alive()) {
      continue;
    }
    ++instance.track.age_frames;
    instance.age.add_frame(interval_ns_);
    instance.track.age_ns = instance.age.ns();
    instance.motion = may_follow_occluder(instance) ? shift_of(instance) : predict_motion(instance, features);
    if (instance.motion_from_flow || !place_mask_by_prediction(instance)) {
      instance.mask.move(instance.motion);
    }
  }
}

bool StereoTracker::may_follow_occluder(const TrackInstance& instance) noexcept {
  return instance.prediction.known && instance.missed.exceeds(kMaxFeatureGap_ns);
}

double StereoTracker::expected_growth(const TrackInstance& instance) noexcept {
  const ObjectPrediction& then = instance.previous_prediction;
  const ObjectPrediction& now = instance.prediction;
  const bool has_depths = then.known && now.known && !then.direction_only && !now.direction_only &&
                          then.depth_m > kMinPredictionDepth_m && now.depth_m > kMinPredictionDepth_m;
  const double last_growth = is_unoccluded(instance) ? instance.motion.scale() : 1.0;
  const double growth = has_depths ? then.depth_m / now.depth_m : last_growth;
  return std::clamp(growth, 1.0 / kMaxGrowth, kMaxGrowth);
}

Similarity StereoTracker::with_growth(const Similarity& motion, double growth,
                                      const Eigen::Vector2d& center_px) noexcept {
  return Similarity::about(center_px, growth, motion * center_px - center_px);
}

Similarity StereoTracker::shift_of(TrackInstance& instance) noexcept {
  instance.motion_from_flow = false;
  return with_growth(instance.motion, 1.0, instance.mask.current_center());
}

bool StereoTracker::is_scale_observable(const TrackInstance& instance, std::size_t features) noexcept {
  return is_unoccluded(instance) ||
         std::sqrt(static_cast<double>(features) * instance.overlap.area_px) >= kMinScaleSupport_px;
}

void StereoTracker::set_predictions(std::span<const ObjectPrediction> object_predictions) noexcept {
  for (std::size_t slot = 0; slot < slots_.size(); ++slot) {
    slots_[slot].previous_prediction = slots_[slot].prediction;
    slots_[slot].prediction = slot < object_predictions.size() ? object_predictions[slot] : ObjectPrediction{};
  }
}

bool StereoTracker::place_mask_by_prediction(TrackInstance& instance) noexcept {
  const ObjectPrediction& now = instance.prediction;
  const ObjectPrediction& then = instance.mask_prediction;
  if (instance.track.missed_frames > 0 && is_behind_camera(instance)) {
    instance.mask.place(Similarity::about(then.point_px, 1.0, Eigen::Vector2d(kFarOutsidePx, kFarOutsidePx)));
    return true;
  }
  if (!now.known || !then.known || now.direction_only != then.direction_only) {
    return false;
  }
  const auto place = [&](double growth) {
    const Similarity motion =
        instance.mask.place(Similarity::about(then.point_px, growth, now.point_px - then.point_px));
    // A return from far outside the image is a placement, not a motion.
    instance.motion = instance.mask_part_in_image > 0.0 ? motion : instance.motion;
    return true;
  };
  if (now.direction_only) {
    return place(1.0);
  }
  if (std::min(then.depth_m, now.depth_m) > kMinPredictionDepth_m) {
    return place(then.depth_m / now.depth_m);
  }
  return false;  // it passes close by: its last motion is the better prediction
}

Similarity StereoTracker::predict_motion(TrackInstance& instance, std::span<const Feature> features) {
  std::size_t pairs = 0;
  std::size_t disparities = 0;
  for (const Feature& f : features) {
    if (f.body != instance.track.label() || lies_in_front(f, instance.prediction)) {
      continue;
    }
    if (f.age_frames > 0 && pairs < pairs_.size()) {
      pairs_[pairs++] = {f.previous_left_px, f.left_px};
    }
    if (f.has_right() && disparities < scratch_.size()) {
      scratch_[disparities++] = f.disparity_px();
    }
  }
  if (disparities > 0) {
    instance.disparity.known = true;
    instance.disparity.mean_px = median(scratch_.first(disparities));
  }

  instance.motion_from_flow = pairs > 0;
  const std::span<const PointPair> moved = pairs_.first(pairs);
  const SimilarityOptions options{.threshold_px = config_.ransac_threshold_px,
                                  .iterations = config_.ransac_iterations,
                                  .max_edge_error_px = 4.0,
                                  .reach_px = instance.mask.current_reach_px()};
  if (const auto fitted = fit_similarity(moved, options, instance.track.id * 65537U + frame_)) {
    return is_scale_observable(instance, pairs)
               ? *fitted
               : with_growth(*fitted, expected_growth(instance), instance.mask.current_center());
  }
  if (!moved.empty()) {
    return Similarity::about(instance.mask.current_center(), expected_growth(instance),
                             median_translation(moved, scratch_));
  }
  return with_growth(instance.motion, expected_growth(instance), instance.mask.current_center());
}

bool StereoTracker::occludes(const TrackInstance& front, const TrackInstance& behind) noexcept {
  const bool contradicted = front.disparity.known && behind.disparity.known &&
                            is_significantly_nearer(behind.disparity.mean_px, front.disparity.mean_px);
  return (behind.occluder_slots & slot_bit(front)) != 0 && !contradicted;
}

bool StereoTracker::is_in_front(const TrackInstance& a, const TrackInstance& b) noexcept {
  const bool a_occludes_b = occludes(a, b);
  const bool b_occludes_a = occludes(b, a);
  return a_occludes_b != b_occludes_a ? a_occludes_b : is_nearer_by_disparity(a, b);
}

bool StereoTracker::is_nearer_by_disparity(const TrackInstance& a, const TrackInstance& b) noexcept {
  const auto key = [](const TrackInstance& i) { return i.disparity.known ? i.disparity.mean_px : 0.F; };
  if (key(a) != key(b)) {
    return key(a) > key(b);
  }
  return a.track.box_px.y1 != b.track.box_px.y1 ? a.track.box_px.y1 > b.track.box_px.y1 : a.track.id < b.track.id;
}

void StereoTracker::sort_far_to_near() noexcept {
  far_to_near_.clear();
  std::uint64_t remaining = 0;
  std::array<std::uint64_t, kMaxObjects> occluded{};  // By slot: the tracks that it occludes.
  for (const TrackInstance& instance : slots_) {
    if (!instance.alive()) {
      continue;
    }
    remaining |= slot_bit(instance);
    for (std::uint64_t rest = instance.occluder_slots; rest != 0; rest &= rest - 1) {
      const auto front = static_cast<std::size_t>(std::countr_zero(rest));
      occluded[front] |= occludes(slots_[front], instance) ? slot_bit(instance) : 0U;
    }
  }
  // Topological order: the next track occludes none of the remaining ones; of several, the farthest. A cycle of
  // observed occlusions leaves none: then the farthest of all.
  while (remaining != 0) {
    const TrackInstance* next = nullptr;
    bool next_occludes = true;
    for (std::uint64_t rest = remaining; rest != 0; rest &= rest - 1) {
      const TrackInstance& candidate = slots_[static_cast<std::size_t>(std::countr_zero(rest))];
      const bool candidate_occludes = (occluded[candidate.track.slot] & remaining) != 0;
      if (next == nullptr ||
          (candidate_occludes != next_occludes ? next_occludes : is_nearer_by_disparity(*next, candidate))) {
        next = &candidate;
        next_occludes = candidate_occludes;
      }
    }
    (void)far_to_near_.push_back(next->track.slot);  // as many places as slots
    remaining &= ~slot_bit(*next);
  }
}

void StereoTracker::draw_predictions(LabelView detections) noexcept {
  clear_labels(prediction_);
  sort_far_to_near();
  for (const std::uint8_t slot : far_to_near_) {
    TrackInstance& instance = slots_[slot];
    const std::uint8_t label = instance.track.label();
    int drawn = 0;
    instance.whole_mask_on_label.fill(0);
    instance.mask_part_in_image = instance.mask.part_in_image();
    instance.mask.for_each_pixel(instance.mask.current_box(), [&](int x, int y) {
      ++instance.whole_mask_on_label[detections.empty() ? kBackgroundLabel : detections.at(x, y)];
      prediction_.data[static_cast<std::ptrdiff_t>(y) * prediction_.stride + x] = label;
      ++drawn;
    });
    instance.predicted_px = drawn;
  }
  erase_hidden();
}

void StereoTracker::erase_hidden() noexcept {
  for (const TrackInstance& behind : slots_) {
    if (!behind.alive() || behind.track.missed_frames == 0 || behind.prediction.disparity_px <= 0.0) {
      continue;
    }
    for (const TrackInstance& front : slots_) {
      if (front.alive() && front.track.missed_frames == 0 && front.prediction.volume &&
          front.prediction.disparity_px > behind.prediction.disparity_px) {
        erase_hidden(behind, *front.prediction.volume);
      }
    }
  }
}

void StereoTracker::erase_hidden(const TrackInstance& behind, const PredictedVolume& front) noexcept {
  const std::uint8_t label = behind.track.label();
  const PixelBox box = behind.mask.current_box();
  for (int y = box.y0; y < box.y1; y += kBlock_px) {
    for (int x = box.x0; x < box.x1; x += kBlock_px) {
      const Eigen::Vector2d middle_px = Eigen::Vector2d(x, y).array() + 0.5 * (kBlock_px - 1);
      if (!front.hides(middle_px, behind.prediction.disparity_px)) {
        continue;
      }
      for (int row = y; row < std::min(y + kBlock_px, box.y1); ++row) {
        std::uint8_t* const pixels = prediction_.row(row);
        std::replace(pixels + x, pixels + std::min(x + kBlock_px, box.x1), label, kBackgroundLabel);
      }
    }
  }
}

void StereoTracker::estimate_occlusion_order(const DetectionFrame& detections) noexcept {
  const auto occluded_by = [&](const TrackInstance& behind, const TrackInstance& front) {
    return front.detection < 0
               ? 0
               : behind.whole_mask_on_label[detections.left[static_cast<std::size_t>(front.detection)].label];
  };
  for (TrackInstance& behind : slots_) {
    for (const TrackInstance& front : slots_) {
      if (!behind.alive() || !front.alive() || &behind == &front) {
        continue;
      }
      const int occluded = occluded_by(behind, front);
      const std::uint64_t bit = slot_bit(front);
      if (occluded >= kMinOccludedPx && occluded >= kOcclusionRatio * occluded_by(front, behind)) {
        behind.occluder_slots |= bit;
      } else if (occluded_by(front, behind) >= kMinOccludedPx) {
        behind.occluder_slots &= ~bit;
      }
    }
  }
}

}  // namespace kinetrace::tracking
