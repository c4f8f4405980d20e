#include "kinetrace/tracking/stereo_tracker.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <numeric>
#include <string>
#include <utility>

#include "expectations.hpp"

namespace kinetrace::tracking {
namespace {

/// Features used per object; more do not improve four parameters.
constexpr std::size_t kMaxFeaturesPerObject = 256;
/// Minimum intersection over union of a detection that fits its prediction.
constexpr double kMinMatchOverlap = 0.6;
/// Minimum part on the whole prediction of a detection that is a fragment of it.
constexpr double kMinFragmentFraction = 0.5;
/// The background keeps half of the image, which the camera's pose needs: a prediction that takes more is mostly wrong.
constexpr double kMaxPredictedPart = 0.5;
/// An image larger than this is a mistake.
constexpr int kMaxImageSidePx = 16384;

PixelBox intersection(const PixelBox& a, const PixelBox& b) noexcept {
  return {std::max(a.x0, b.x0), std::max(a.y0, b.y0), std::min(a.x1, b.x1), std::min(a.y1, b.y1)};
}

/// Box of a whole object of which a part is seen: as large as predicted, moved as little as possible to contain that
/// part.
PixelBox shifted_to_contain(const PixelBox& seen, const PixelBox& predicted) noexcept {
  const int width = std::max(seen.width(), predicted.width());
  const int height = std::max(seen.height(), predicted.height());
  const int x0 = std::clamp(predicted.x0, seen.x1 - width, seen.x0);
  const int y0 = std::clamp(predicted.y0, seen.y1 - height, seen.y0);
  return {x0, y0, x0 + width, y0 + height};
}

/// Prediction for a track without one: the direction of its box, should it never get a position.
ObjectPrediction direction_of(const PixelBox& box) noexcept {
  return {.known = true, .point_px = {box.center_x(), box.center_y()}, .depth_m = 0.0, .direction_only = true};
}

}  // namespace

void StereoTracker::carve(const TrackerConfig& config, int width_px, int height_px, Arena& arena,
                          StereoTracker& tracker) {
  const auto objects = static_cast<std::size_t>(config.max_objects);
  tracker.left_ = take_image<std::uint8_t>(arena, width_px, height_px);
  tracker.right_ = take_image<std::uint8_t>(arena, width_px, height_px);
  tracker.prediction_ = take_image<std::uint8_t>(arena, width_px, height_px);
  tracker.slots_ = FixedVector<TrackInstance>(arena, objects);
  tracker.slots_.resize(objects);
  for (std::size_t i = 0; i < objects; ++i) {
    ReferenceMask mask(arena, width_px, height_px);
    if (!arena.measuring() && !arena.exhausted()) {
      tracker.slots_[i].mask = mask;
    }
  }
  tracker.spare_mask_ = ReferenceMask(arena, width_px, height_px);
  tracker.far_to_near_ = FixedVector<std::uint8_t>(arena, objects);
  tracker.owner_ = FixedVector<std::int16_t>(arena, kMaxObjects);
  tracker.published_ = FixedVector<Track>(arena, objects);
  tracker.ended_ = FixedVector<Track>(arena, objects);
  tracker.pairs_ = arena.take<PointPair>(kMaxFeaturesPerObject);
  tracker.samples_ = arena.take<DisparitySample>(kMaxFeaturesPerObject);
  tracker.scratch_ = arena.take<float>(kMaxFeaturesPerObject);
}

std::size_t StereoTracker::required_bytes(const TrackerConfig& config, int width_px, int height_px) {
  return measure_bytes([&](Arena& arena) {
    StereoTracker tracker;
    carve(config, width_px, height_px, arena, tracker);
  });
}

Result<StereoTracker> StereoTracker::create(const TrackerConfig& config, int width_px, int height_px, Arena& arena) {
  if (const Status valid = config.validate(); !valid) {
    return Unexpected(valid.error());
  }
  if (width_px < 1 || height_px < 1 || width_px > kMaxImageSidePx || height_px > kMaxImageSidePx) {
    return fail(ErrorCode::kInvalidArgument, "tracking: image size " + std::to_string(width_px) + "x" +
                                                 std::to_string(height_px) + " is outside 1.." +
                                                 std::to_string(kMaxImageSidePx) + " px a side");
  }
  StereoTracker tracker;
  carve(config, width_px, height_px, arena, tracker);
  if (arena.exhausted()) {
    return fail(ErrorCode::kCapacity, "tracking: the arena does not hold " +
                                          std::to_string(required_bytes(config, width_px, height_px)) +
                                          " bytes; size it with StereoTracker::required_bytes");
  }
  tracker.config_ = config;
  tracker.limits_ = {to_ns(config.max_missed_s), to_ns(config.max_unseen_s), to_ns(config.max_tentative_missed_s)};
  tracker.width_px_ = width_px;
  tracker.height_px_ = height_px;
  return tracker;
}

void StereoTracker::reset() noexcept {
  for (TrackInstance& instance : slots_) {
    instance.life = LifeState::kFree;
  }
  published_.clear();
  ended_.clear();
  started_ = false;
}

Status StereoTracker::check(const DetectionFrame& detections) const {
  for (const LabelView& labels : {detections.left_labels, detections.right_labels}) {
    if (!labels.empty() && (labels.width != width_px_ || labels.height != height_px_)) {
      return fail(ErrorCode::kInvalidArgument, "tracking: masks of " + std::to_string(labels.width) + "x" +
                                                   std::to_string(labels.height) + " px for images of " +
                                                   std::to_string(width_px_) + "x" + std::to_string(height_px_));
    }
  }
  if (detections.left.size() > kMaxObjects || detections.right.size() > kMaxObjects) {
    return fail(ErrorCode::kInvalidArgument,
                "tracking: more than " + std::to_string(kMaxObjects) + " detections in one image");
  }
  return {};
}

// P_{i+1,ln} <- T_i; A <- overlap of P and D_{i+1,l}; Kuhn-Munkres; T_{i+1,l}; P_{i+1,lr} <- T_{i+1,l}; Kuhn-Munkres.
Result<TrackFrame> StereoTracker::process(std::int64_t timestamp_ns, const DetectionFrame& detections,
                                          std::span<const Feature> features,
                                          std::span<const ObjectPrediction> object_predictions) {
  if (const Status sizes = check(detections); !sizes) {
    return Unexpected(sizes.error());
  }
  begin_frame(timestamp_ns);
  set_predictions(object_predictions);
  predict(features);
  draw_predictions(detections.available ? detections.left_labels : LabelView{});
  associate(detections, features);
  estimate_occlusion_order(detections);
  initiate_tracks(detections, features);
  draw_left(detections);
  attach_right(detections, features);
  publish();
  return TrackFrame{left_, right_, published_.span(), ended_.span()};
}

void StereoTracker::begin_frame(std::int64_t timestamp_ns) noexcept {
  ++frame_;
  interval_ns_ = started_ ? timestamp_ns - timestamp_ns_ : kUsualInterval_ns;
  timestamp_ns_ = timestamp_ns;
  started_ = true;
  ended_.clear();
  for (TrackInstance& instance : slots_) {
    if (instance.life == LifeState::kEnded) {
      instance.life = LifeState::kFree;
    } else if (instance.terminated) {
      advance(instance, {.terminated = true});
    }
  }
  prune_to_capacity();
}

void StereoTracker::terminate(std::uint8_t slot) noexcept {
  if (slot < slots_.size()) {
    slots_[slot].terminated = slots_[slot].alive();
  }
}

void StereoTracker::merge_tracks(std::uint8_t earlier, std::uint8_t redetected) noexcept {
  TrackInstance& from = slots_[earlier];
  TrackInstance& to = slots_[redetected];
  to.track.id = from.track.id;
  to.life = from.tentative() ? to.life : LifeState::kConfirmed;
  to.track.state = track_state(to.life);
  to.track.age_frames = from.track.age_frames;
  to.track.age_ns = from.track.age_ns;
  to.age = from.age;
  to.matched_frames += from.matched_frames;
  from.votes.add(to.track.class_id);
  to.votes = from.votes;
  to.track.class_id = to.votes.winner();
  if (from.prediction.known) {  // of this frame, from which its mask is
    to.prediction = to.mask_prediction = from.prediction;
  }
  from.life = LifeState::kFree;
  LabelTable without_earlier;
  std::iota(without_earlier.begin(), without_earlier.end(), std::uint8_t{0});
  without_earlier[from.track.label()] = kBackgroundLabel;
  relabel(left_, without_earlier, left_);
  relabel(right_, without_earlier, right_);
  const auto kept = std::remove_if(published_.begin(), published_.end(),
                                   [earlier](const Track& track) { return track.slot == earlier; });
  published_.resize(static_cast<std::size_t>(kept - published_.begin()));
  std::replace_if(
      published_.begin(), published_.end(), [redetected](const Track& track) { return track.slot == redetected; },
      to.track);
  sort_published();
}

void StereoTracker::accept_match(TrackInstance& instance, const Detection& detection) noexcept {
  ++instance.matched_frames;
  instance.missed_searched.reset();
  instance.earlier_misses += std::exchange(instance.misses, 0);
  instance.missed_in_sight.reset();
  instance.votes.add(detection.class_id);
  instance.track.class_id = instance.votes.winner();
  advance(instance, {.detected = true, .often_detected = instance.matched_frames >= config_.confirm_frames});
  if (!instance.motion_from_flow) {
    correct_motion(instance, detection);
  }
  instance.matched_timestamp_ns = timestamp_ns_;
  instance.missed.reset();
  instance.track.missed_ns = 0;
  instance.track.mask_lost = false;
  instance.track.missed_frames = 0;
}

// Without features the object's motion follows from its masks: the innovation, spread over the frames since the last
// match, corrects the motion used for the next prediction.
void StereoTracker::correct_motion(TrackInstance& instance, const Detection& detection) const noexcept {
  const PixelBox& predicted = instance.overlap.box_px;
  if (predicted.empty() || !is_unoccluded(instance) || predicted.touches_border(width_px_, height_px_) ||
      detection.box_px.touches_border(width_px_, height_px_)) {
    return;
  }
  const auto center = [](const PixelBox& box) { return Eigen::Vector2d(box.center_x(), box.center_y()); };
  const double frames = instance.track.missed_frames + 1.0;
  const double area_ratio = static_cast<double>(detection.area_px) / instance.overlap.area_px;
  const double scale = std::clamp(std::pow(area_ratio, 0.5 / frames), 1.0 / kMaxGrowth, kMaxGrowth);
  const Eigen::Vector2d shift = (center(detection.box_px) - center(predicted)) / frames;
  instance.motion = Similarity::about(center(predicted), scale, shift) * instance.motion;
}

void StereoTracker::accept_miss(TrackInstance& instance, bool was_looked_for) noexcept {
  ++instance.track.missed_frames;
  instance.missed.add_frame(interval_ns_);
  instance.track.missed_ns = instance.missed.ns();
  LifeEvidence evidence;
  evidence.has_prediction = !instance.tentative() && instance.prediction.known;
  evidence.in_plain_sight = !evidence.has_prediction || !is_out_of_view(instance);
  if (was_looked_for) {
    instance.missed_searched.add_frame(interval_ns_);
    ++instance.misses;
  }
  instance.track.mask_lost = instance.is_mask_lost();
  if (evidence.in_plain_sight) {
    instance.missed_in_sight.add_frame(interval_ns_);
  }
  evidence.vanished = instance.predicted_px < config_.min_area_px;
  evidence.missed = instance.missed.exceeds(limits_.missed_ns);
  evidence.missed_in_sight = instance.missed_in_sight.exceeds(limits_.missed_ns);
  evidence.missed_tentative = instance.missed_searched.exceeds(limits_.tentative_missed_ns);
  evidence.coasted_too_long = instance.missed.exceeds(limits_.unseen_ns + limits_.missed_ns);
  advance(instance, evidence);
}

void StereoTracker::advance(TrackInstance& instance, const LifeEvidence& evidence) noexcept {
  const LifeState before = instance.life;
  instance.life = next(before, evidence);
  if (instance.life == LifeState::kEnded) {
    end(instance);
    return;
  }
  instance.track.state = track_state(instance.life);
  counters_.confirmed += before == LifeState::kTentative && instance.life == LifeState::kConfirmed ? 1U : 0U;
}

double StereoTracker::overlap_fraction(const TrackInstance& instance, const Detection& detection) noexcept {
  return static_cast<double>(instance.whole_mask_on_label[detection.label]) / detection.area_px;
}

bool StereoTracker::is_behind_camera(const TrackInstance& instance) noexcept {
  const ObjectPrediction& prediction = instance.prediction;
  return prediction.known && prediction.depth_m <= kMinPredictionDepth_m;
}

bool StereoTracker::is_assignable(const TrackInstance& instance) noexcept {
  return instance.life != LifeState::kDormant;
}

bool StereoTracker::is_out_of_view(const TrackInstance& instance) const noexcept {
  return instance.predicted_px < config_.min_area_px || instance.overlap.area_px < config_.min_area_px ||
         instance.mask_part_in_image < kMinVisiblePart ||
         instance.overlap.area_px < kMinVisiblePart * instance.predicted_px;
}

void StereoTracker::end(TrackInstance& instance) noexcept {
  instance.life = LifeState::kEnded;
  (void)ended_.push_back(instance.track);  // as many places as slots, and each ends once
  ++counters_.ended;
}

void StereoTracker::draw_left(const DetectionFrame& detections) noexcept {
  LabelTable table;
  table.fill(kIgnoreLabel);
  table[kBackgroundLabel] = kBackgroundLabel;
  for (std::size_t v = 0; v < owner_.size(); ++v) {
    if (owner_[v] >= 0) {
      table[detections.left[v].label] = slots_[static_cast<std::size_t>(owner_[v])].track.label();
    }
  }
  if (detections.available && !detections.left_labels.empty()) {
    relabel(detections.left_labels, table, left_);
  } else {
    clear_labels(left_);
  }
  for (TrackInstance& instance : slots_) {
    if (!instance.alive()) {
      continue;
    }
    instance.track.detected_moving = false;
    if (instance.detection >= 0) {
      const Detection& detection = detections.left[static_cast<std::size_t>(instance.detection)];
      instance.track.detected_moving = detection.moving;
      instance.track.box_px = detection.box_px;
      instance.track.area_px = detection.area_px;
      continue;
    }
    if (instance.missed.exceeds(limits_.missed_ns) ||
        instance.overlap.area_px > kMaxPredictedPart * width_px_ * height_px_) {
      // It waits for re-detection; its prediction is too uncertain to own pixels.
      instance.track.box_px = {};
      instance.track.area_px = 0;
      continue;
    }
    const LabelRegion shown = assign_free_pixels(prediction_, instance.track.label(), instance.overlap.box_px, left_);
    instance.track.box_px = shown.box_px;
    instance.track.area_px = shown.area_px;
  }
  // All pixels are assigned by now, so that occluded parts are known.
  for (TrackInstance& instance : slots_) {
    if (instance.alive() && instance.detection >= 0) {
      remember_mask(instance, detections.left[static_cast<std::size_t>(instance.detection)]);
    }
  }
}

// The mask to predict from: the detected pixels, and those of the old mask now occluded by a nearer object. So an
// object that passes behind another keeps its full shape and is associated as soon as any part of it reappears.
void StereoTracker::remember_mask(TrackInstance& instance, const Detection& detection) noexcept {
  const double fit =
      intersection_over_union(instance.overlap.on_label[detection.label], instance.overlap.area_px, detection.area_px);
  const bool is_truncated = instance.prediction.known && instance.mask_part_in_image < kMinFractionInImage;
  if (((is_truncated || !is_unoccluded(instance)) && fit > kMinMatchOverlap) ||
      (detection.area_px < instance.predicted_px && overlap_fraction(instance, detection) >= kMinFragmentFraction &&
       has_undetected_occluder(instance))) {
    return;
  }
  instance.mask_prediction = instance.prediction.known ? instance.prediction : direction_of(instance.track.box_px);
  const std::uint8_t label = instance.track.label();
  PixelBox box = instance.track.box_px;
  // Occlusion must not enlarge a mask: prediction errors would accumulate frame by frame.
  const PixelBox predicted_box =
      intersection(instance.mask.current_box(), shifted_to_contain(box, instance.mask.current_box()));
  const bool is_partly_occluded = instance.overlap.area_px < instance.predicted_px;
  if (!is_partly_occluded || predicted_box.empty()) {
    instance.mask.capture(left_, box, [&](std::uint8_t pixel, int, int) { return pixel == label; });
    return;
  }
  const auto is_occluder = [&](std::uint8_t pixel) {
    return pixel != label && pixel != kBackgroundLabel && pixel <= slots_.size() && slots_[pixel - 1U].alive() &&
           is_in_front(slots_[pixel - 1U], instance);
  };
  instance.mask.for_each_pixel(predicted_box, [&](int x, int y) {
    std::uint8_t& pixel = prediction_.data[static_cast<std::ptrdiff_t>(y) * prediction_.stride + x];
    const std::uint8_t shown = left_.data[static_cast<std::ptrdiff_t>(y) * left_.stride + x];
    pixel = is_occluder(shown) ? kIgnoreLabel : pixel;  // the prediction image is reused for marks
  });
  box.include(predicted_box.x0, predicted_box.y0);
  box.include(predicted_box.x1 - 1, predicted_box.y1 - 1);
  spare_mask_.capture(left_, box, [&](std::uint8_t pixel, int x, int y) {
    return pixel == label || prediction_.at(x, y) == kIgnoreLabel;
  });
  std::swap(spare_mask_, instance.mask);
  for (int y = predicted_box.y0; y < predicted_box.y1; ++y) {
    std::replace(prediction_.row(y) + predicted_box.x0, prediction_.row(y) + predicted_box.x1, kIgnoreLabel,
                 kBackgroundLabel);
  }
}

bool StereoTracker::has_undetected_occluder(const TrackInstance& instance) const noexcept {
  for (std::uint64_t rest = instance.occluder_slots; rest != 0; rest &= rest - 1) {
    const TrackInstance& front = slots_[static_cast<std::size_t>(std::countr_zero(rest))];
    if (front.alive() && front.detection < 0 && occludes(front, instance) &&
        !intersection(front.mask.current_box(), instance.mask.current_box()).empty()) {
      return true;
    }
  }
  return false;
}

void StereoTracker::publish() noexcept {
  published_.clear();
  for (TrackInstance& instance : slots_) {
    if (instance.alive()) {
      const int seen_px = instance.detection >= 0 ? instance.track.area_px : instance.overlap.area_px;
      const double shown = instance.predicted_px > 0 ? static_cast<double>(seen_px) / instance.predicted_px : 0.0;
      const double both = std::min(shown, instance.right_visible_fraction);
      const double part = instance.track.age_frames == 0 ? 1.0 : both * instance.mask_part_in_image;
      instance.track.visible_part = static_cast<float>(std::min(part, 1.0));
      (void)published_.push_back(instance.track);  // as many places as slots
    }
  }
  sort_published();
}

void StereoTracker::sort_published() noexcept {
  std::sort(published_.begin(), published_.end(), [](const Track& a, const Track& b) { return a.id < b.id; });
}

}  // namespace kinetrace::tracking
