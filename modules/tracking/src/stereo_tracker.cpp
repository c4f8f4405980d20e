#include "kinetrace/tracking/stereo_tracker.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <string>

#include "expectations.hpp"

namespace kinetrace::tracking {
namespace {

/// Features looked at per object; more say nothing new about four parameters.
constexpr std::size_t kMaxFeaturesPerObject = 256;
/// A network may err in the class of a frame, but what comes back after this many has to be of the same.
constexpr int kForgetsClassFrames = 2;
constexpr double kMostForecastScale = 3.0;
/// Where masks of things behind the camera, or too near, are put.
constexpr double kFarOutsidePx = 1e6;
/// A mask is still found where it is expected if it overlaps its prediction so far.
constexpr double kStillFits = 0.6;
constexpr double kWholeInSight = 0.9;
constexpr double kLeastPartToClaim = 0.2;
/// Features tell how a thing grows to .3 px over their spread and the root of their number: as much as the nearest of
/// what is small grows from frame to frame. Less must not add up in what is hidden, which no detection puts right.
constexpr double kTellsSize_px = 60.0;
/// An image larger than this is a mistake.
constexpr int kMaxImageSidePx = 16384;
/// So many features that speak against a match weigh as much as those that speak for it.
constexpr double kVotesPrior = 3.0;
/// Share of an object's features that makes a match whatever the masks overlap.
constexpr double kMinVotes = 0.5;
/// Fewer hidden pixels may be the raggedness of masks.
constexpr int kMinHiddenPx = 24;
/// The one in front hides this many times more of the other than the other of it.
constexpr int kHiddenRatio = 3;

PixelBox common_part(const PixelBox& a, const PixelBox& b) noexcept {
  return {std::max(a.x0, b.x0), std::max(a.y0, b.y0), std::min(a.x1, b.x1), std::min(a.y1, b.y1)};
}

/// Where all of a thing lies that shows a part: as large as was predicted, and moved only so far that it holds that.
PixelBox slid_to_hold(const PixelBox& seen, const PixelBox& predicted) noexcept {
  const int width = std::max(seen.width(), predicted.width());
  const int height = std::max(seen.height(), predicted.height());
  const int x0 = std::clamp(predicted.x0, seen.x1 - width, seen.x0);
  const int y0 = std::clamp(predicted.y0, seen.y1 - height, seen.y0);
  return {x0, y0, x0 + width, y0 + height};
}

/// Of a track that nothing is foretold of yet: should it get no place, its direction will be that of its box.
Forecast direction_of(const PixelBox& box) noexcept {
  return {.known = true,
          .point_px = {0.5 * (box.x0 + box.x1 - 1), 0.5 * (box.y0 + box.y1 - 1)},
          .depth_m = 0.0,
          .direction_only = true};
}

std::uint64_t slot_bit(const TrackInstance& instance) noexcept {
  return std::uint64_t{1} << instance.track.slot;
}

TrackState state_of(const TrackInstance& instance, const TrackerConfig& config) noexcept {
  if (instance.matched_frames < config.confirm_frames && instance.track.state == TrackState::kTentative) {
    return TrackState::kTentative;
  }
  return instance.detection >= 0 ? TrackState::kConfirmed : TrackState::kPropagated;
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
  tracker.width_px_ = width_px;
  tracker.height_px_ = height_px;
  return tracker;
}

void StereoTracker::reset() noexcept {
  for (TrackInstance& instance : slots_) {
    instance.slot_state = TrackInstance::Slot::kFree;
  }
  published_.clear();
  ended_.clear();
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
Result<TrackFrame> StereoTracker::process(const DetectionFrame& detections, std::span<const Feature> features,
                                          std::span<const Forecast> forecasts) {
  if (const Status sizes = check(detections); !sizes) {
    return Unexpected(sizes.error());
  }
  begin_frame();
  take_forecasts(forecasts);
  predict(features);
  draw_predictions(detections.available ? detections.left_labels : LabelView{});
  associate(detections, features);
  learn_order(detections);
  bear(detections, features);
  draw_left(detections);
  attach_right(detections, features);
  publish();
  return TrackFrame{left_, right_, published_.span(), ended_.span()};
}

void StereoTracker::begin_frame() noexcept {
  ++frame_;
  ended_.clear();
  for (TrackInstance& instance : slots_) {
    if (instance.slot_state == TrackInstance::Slot::kEnded) {
      instance.slot_state = TrackInstance::Slot::kFree;
    } else if (instance.alive() && instance.abandoned) {
      end(instance);
    }
  }
  shed();
}

void StereoTracker::abandon(std::uint8_t slot) noexcept {
  if (slot < slots_.size()) {
    slots_[slot].abandoned = slots_[slot].alive();
  }
}

void StereoTracker::join(std::uint8_t earlier, std::uint8_t reborn) noexcept {
  TrackInstance& from = slots_[earlier];
  TrackInstance& to = slots_[reborn];
  to.track.id = from.track.id;
  to.track.state = from.track.state == TrackState::kTentative ? to.track.state : TrackState::kConfirmed;
  to.track.age_frames = from.track.age_frames;
  to.matched_frames += from.matched_frames;
  to.votes = from.votes;
  from.slot_state = TrackInstance::Slot::kFree;
  for (Track& track : published_) {
    if (track.slot == earlier) {
      track.area_px = 0;
      track.box_px = {};
    } else if (track.slot == reborn) {
      track = to.track;
    }
  }
}

void StereoTracker::predict(std::span<const Feature> features) {
  for (TrackInstance& instance : slots_) {
    if (!instance.alive()) {
      continue;
    }
    ++instance.track.age_frames;
    instance.motion = flow_may_be_foreign(instance) ? shift_of(instance) : predict_motion(instance, features);
    if (instance.motion_from_flow || !place_by_forecast(instance)) {
      instance.mask.move(instance.motion);
    }
  }
}

bool StereoTracker::flow_may_be_foreign(const TrackInstance& instance) const noexcept {
  const int missed = instance.track.missed_frames;
  return instance.forecast.known && (missed >= kForeignAfterFrames || (missed > 0 && out_of_sight(instance)));
}

Similarity StereoTracker::without_growth(const Similarity& motion, const Eigen::Vector2d& center_px) noexcept {
  return Similarity::about(center_px, 1.0, motion * center_px - center_px);
}

Similarity StereoTracker::shift_of(TrackInstance& instance) noexcept {
  instance.motion_from_flow = false;
  return without_growth(instance.motion, instance.mask.current_center());
}

bool StereoTracker::shows_size(const TrackInstance& instance, std::size_t features) noexcept {
  const bool whole = instance.overlap.area_px >= kWholeInSight * instance.predicted_px;
  return whole || std::sqrt(static_cast<double>(features) * instance.overlap.area_px) >= kTellsSize_px;
}

void StereoTracker::take_forecasts(std::span<const Forecast> forecasts) noexcept {
  for (std::size_t slot = 0; slot < slots_.size(); ++slot) {
    slots_[slot].forecast = slot < forecasts.size() ? forecasts[slot] : Forecast{};
  }
}

bool StereoTracker::place_by_forecast(TrackInstance& instance) noexcept {
  const Forecast& now = instance.forecast;
  const Forecast& then = instance.mask_forecast;
  if (!now.known || !then.known || now.direction_only != then.direction_only ||
      (!then.direction_only && then.depth_m <= kMinForecastDepth_m)) {
    return false;
  }
  // A mask says nothing about what is seen from much nearer; one that is blown up would claim the whole image.
  const double nearest_m =
      now.direction_only ? kMinForecastDepth_m : std::max(kMinForecastDepth_m, then.depth_m / kMostForecastScale);
  if (now.depth_m <= nearest_m) {
    instance.mask.place(Similarity::about(then.point_px, 1.0, Eigen::Vector2d(kFarOutsidePx, kFarOutsidePx)));
  } else {
    const double scale = now.direction_only ? 1.0 : then.depth_m / now.depth_m;
    instance.mask.place(Similarity::about(then.point_px, scale, now.point_px - then.point_px));
  }
  return true;
}

Similarity StereoTracker::predict_motion(TrackInstance& instance, std::span<const Feature> features) {
  std::size_t pairs = 0;
  std::size_t disparities = 0;
  for (const Feature& f : features) {
    if (f.body != instance.track.label()) {
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
    const auto middle = scratch_.begin() + static_cast<std::ptrdiff_t>(disparities / 2);
    std::nth_element(scratch_.begin(), middle, scratch_.begin() + static_cast<std::ptrdiff_t>(disparities));
    instance.disparity.known = true;
    instance.disparity.mean_px = *middle;
  }

  instance.motion_from_flow = pairs > 0;
  const std::span<const PointPair> moved = pairs_.first(pairs);
  const SimilarityOptions options{.threshold_px = config_.ransac_threshold_px,
                                  .iterations = config_.ransac_iterations,
                                  .max_edge_error_px = 4.0,
                                  .reach_px = instance.mask.current_reach_px()};
  if (const auto fitted = fit_similarity(moved, options, instance.track.id * 65537U + frame_)) {
    return shows_size(instance, pairs) ? *fitted : without_growth(*fitted, instance.mask.current_center());
  }
  if (!moved.empty()) {
    return Similarity::about(instance.mask.current_center(), instance.motion.scale(),
                             median_translation(moved, scratch_));
  }
  return instance.motion;
}

bool StereoTracker::nearer(const TrackInstance& a, const TrackInstance& b) noexcept {
  const bool a_hid_b = (b.in_front & slot_bit(a)) != 0;
  const bool b_hid_a = (a.in_front & slot_bit(b)) != 0;
  return a_hid_b != b_hid_a ? a_hid_b : looks_nearer(a, b);
}

bool StereoTracker::looks_nearer(const TrackInstance& a, const TrackInstance& b) noexcept {
  const auto key = [](const TrackInstance& i) { return i.disparity.known ? i.disparity.mean_px : 0.F; };
  if (key(a) != key(b)) {
    return key(a) > key(b);
  }
  return a.track.box_px.y1 != b.track.box_px.y1 ? a.track.box_px.y1 > b.track.box_px.y1 : a.track.id < b.track.id;
}

void StereoTracker::sort_far_to_near() noexcept {
  far_to_near_.clear();
  std::uint64_t waiting = 0;
  std::array<std::uint64_t, kMaxObjects> hides{};  // By slot: the tracks that it has been seen to hide.
  for (const TrackInstance& instance : slots_) {
    if (!instance.alive()) {
      continue;
    }
    waiting |= slot_bit(instance);
    for (std::uint64_t rest = instance.in_front; rest != 0; rest &= rest - 1) {
      hides[static_cast<std::size_t>(std::countr_zero(rest))] |= slot_bit(instance);
    }
  }
  // The next one hides none of those that wait, and of several is the farthest. Three that have been seen to hide each
  // other in a circle leave none: then the farthest of all.
  while (waiting != 0) {
    const TrackInstance* next = nullptr;
    bool next_hides = true;
    for (std::uint64_t rest = waiting; rest != 0; rest &= rest - 1) {
      const TrackInstance& candidate = slots_[static_cast<std::size_t>(std::countr_zero(rest))];
      const bool candidate_hides = (hides[candidate.track.slot] & waiting) != 0;
      if (next == nullptr || (candidate_hides != next_hides ? next_hides : looks_nearer(*next, candidate))) {
        next = &candidate;
        next_hides = candidate_hides;
      }
    }
    (void)far_to_near_.push_back(next->track.slot);  // as many places as slots
    waiting &= ~slot_bit(*next);
  }
}

void StereoTracker::draw_predictions(LabelView detections) noexcept {
  clear_labels(prediction_);
  sort_far_to_near();
  for (const std::uint8_t slot : far_to_near_) {
    TrackInstance& instance = slots_[slot];
    const std::uint8_t label = instance.track.label();
    int drawn = 0;
    instance.whole_on_label.fill(0);
    instance.mask_part_in_image = instance.mask.part_in_image();
    instance.mask.for_each_pixel(instance.mask.current_box(), [&](int x, int y) {
      ++instance.whole_on_label[detections.empty() ? kBackgroundLabel : detections.at(x, y)];
      prediction_.data[static_cast<std::ptrdiff_t>(y) * prediction_.stride + x] = label;
      ++drawn;
    });
    instance.predicted_px = drawn;
  }
}

void StereoTracker::learn_order(const DetectionFrame& detections) noexcept {
  const auto hidden_by = [&](const TrackInstance& behind, const TrackInstance& front) {
    return front.detection < 0
               ? 0
               : behind.whole_on_label[detections.left[static_cast<std::size_t>(front.detection)].label];
  };
  for (TrackInstance& behind : slots_) {
    for (const TrackInstance& front : slots_) {
      if (!behind.alive() || !front.alive() || &behind == &front) {
        continue;
      }
      const int hidden = hidden_by(behind, front);
      const std::uint64_t bit = slot_bit(front);
      if (hidden >= kMinHiddenPx && hidden >= kHiddenRatio * hidden_by(front, behind)) {
        behind.in_front |= bit;
      } else if (hidden_by(front, behind) >= kMinHiddenPx) {
        behind.in_front &= ~bit;
      }
    }
  }
}

void StereoTracker::add_affinities(const TrackInstance& instance, std::span<const Detection> detections) noexcept {
  for (std::size_t v = 0; v < detections.size(); ++v) {
    const double overlap = intersection_over_union(instance.overlap.on_label[detections[v].label],
                                                   instance.overlap.area_px, detections[v].area_px);
    const FeatureVotes& features = instance.votes_of_features;
    const double votes = features.on_label[detections[v].label] / (features.total + kVotesPrior);
    const bool could_be = instance.track.missed_frames < kForgetsClassFrames ||
                          classes_agree(instance.track.class_id, detections[v].class_id);
    if (could_be && (overlap >= config_.min_overlap || votes >= kMinVotes)) {
      affinity_(instance.track.slot, static_cast<int>(v)) = overlap + votes;
    }
  }
}

void StereoTracker::count_votes(LabelView detections, std::span<const Feature> features) noexcept {
  for (TrackInstance& instance : slots_) {
    instance.votes_of_features = {};
  }
  if (detections.empty()) {
    return;
  }
  for (const Feature& feature : features) {
    const auto x = static_cast<int>(std::lround(feature.left_px.x()));
    const auto y = static_cast<int>(std::lround(feature.left_px.y()));
    const bool carried = feature.age_frames > 0 && feature.body != kBackgroundLabel && feature.body <= slots_.size();
    if (carried && x >= 0 && y >= 0 && x < detections.width && y < detections.height) {
      FeatureVotes& votes = slots_[feature.body - 1U].votes_of_features;
      ++votes.total;
      ++votes.on_label[detections.at(x, y)];
    }
  }
}

void StereoTracker::associate(const DetectionFrame& detections, std::span<const Feature> features) noexcept {
  const LabelView labels = detections.available ? detections.left_labels : LabelView{};
  count_votes(labels, features);
  const std::size_t columns = detections.available ? detections.left.size() : 0;
  affinity_.resize(static_cast<int>(slots_.size()), static_cast<int>(columns));
  for (TrackInstance& instance : slots_) {
    if (!instance.alive()) {
      continue;
    }
    measure_overlap(prediction_, instance.track.label(), instance.mask.current_box(), labels, instance.overlap);
    if (may_claim(instance)) {
      add_affinities(instance, detections.left.first(columns));
    }
  }

  owner_.clear();
  owner_.resize(columns);
  std::fill(owner_.begin(), owner_.end(), std::int16_t{-1});
  for (TrackInstance& instance : slots_) {
    instance.detection = -1;
  }
  claim(maximum_weight_assignment(affinity_));
  affinity_.resize(static_cast<int>(slots_.size()), static_cast<int>(columns));
  for (const TrackInstance& instance : slots_) {
    if (instance.alive() && instance.detection < 0 && may_claim(instance)) {
      add_near_misses(instance, detections.left.first(columns));
    }
  }
  claim(maximum_weight_assignment(affinity_));
  for (TrackInstance& instance : slots_) {
    if (!instance.alive()) {
      continue;
    }
    if (instance.detection >= 0) {
      accept_match(instance, detections.left[static_cast<std::size_t>(instance.detection)]);
    } else {
      accept_miss(instance, detections.has_looked_at(instance.overlap.box_px));
    }
  }
}

void StereoTracker::claim(const Assignment& match) noexcept {
  for (TrackInstance& instance : slots_) {
    if (instance.alive() && instance.detection < 0 && match[instance.track.slot] >= 0) {
      instance.detection = match[instance.track.slot];
      owner_[static_cast<std::size_t>(instance.detection)] = instance.track.slot;
    }
  }
}

void StereoTracker::accept_match(TrackInstance& instance, const Detection& detection) noexcept {
  ++instance.matched_frames;
  instance.tentative_missed_frames = 0;
  instance.missed_in_sight_frames = 0;
  instance.votes.add(detection.class_id);
  instance.track.class_id = instance.votes.winner();
  const bool was_tentative = instance.track.state == TrackState::kTentative;
  instance.track.state = state_of(instance, config_);
  counters_.confirmed += was_tentative && instance.track.state == TrackState::kConfirmed ? 1U : 0U;
  if (!instance.motion_from_flow) {
    learn_motion(instance, detection);
  }
  instance.track.missed_frames = 0;
}

// Without features the object's motion is read off its masks: what the last prediction was off by, spread over the
// frames since the last match, corrects the motion used for the next one.
void StereoTracker::learn_motion(TrackInstance& instance, const Detection& detection) const noexcept {
  const PixelBox& predicted = instance.overlap.box_px;
  const auto touches_border = [&](const PixelBox& box) {
    return box.x0 <= 0 || box.y0 <= 0 || box.x1 >= width_px_ || box.y1 >= height_px_;
  };
  const bool hidden = instance.overlap.area_px * 10 < instance.predicted_px * 9;
  if (predicted.empty() || hidden || touches_border(predicted) || touches_border(detection.box_px)) {
    return;
  }
  const auto center = [](const PixelBox& box) {
    return Eigen::Vector2d(0.5 * (box.x0 + box.x1 - 1), 0.5 * (box.y0 + box.y1 - 1));
  };
  const double frames = instance.track.missed_frames + 1.0;
  const double area_ratio = static_cast<double>(detection.area_px) / instance.overlap.area_px;
  const double scale = std::clamp(std::pow(area_ratio, 0.5 / frames), 0.8, 1.25);
  const Eigen::Vector2d shift = (center(detection.box_px) - center(predicted)) / frames;
  instance.motion = Similarity::about(center(predicted), scale, shift) * instance.motion;
}

void StereoTracker::accept_miss(TrackInstance& instance, bool was_looked_for) noexcept {
  Track& track = instance.track;
  ++track.missed_frames;
  const bool tentative = track.state == TrackState::kTentative;
  instance.tentative_missed_frames += tentative && was_looked_for ? 1 : 0;
  track.state = state_of(instance, config_);
  const bool placed = !tentative && instance.forecast.known;
  instance.missed_in_sight_frames += placed && out_of_sight(instance) ? 0 : 1;
  const bool gone =
      !placed && (instance.predicted_px < config_.min_area_px || track.missed_frames > config_.max_missed_frames);
  if (track.missed_frames > config_.max_unseen_frames + config_.max_missed_frames || gone ||
      (tentative && instance.tentative_missed_frames > config_.max_tentative_missed_frames)) {
    end(instance);
  }
}

bool StereoTracker::may_claim(const TrackInstance& instance) const noexcept {
  const bool nearly_outside = instance.track.missed_frames > 0 && instance.mask_part_in_image < kLeastPartToClaim;
  return !nearly_outside && instance.missed_in_sight_frames <= config_.max_missed_frames;
}

bool StereoTracker::out_of_sight(const TrackInstance& instance) const noexcept {
  return instance.predicted_px < config_.min_area_px || instance.overlap.area_px < config_.min_area_px ||
         instance.mask_part_in_image < kLeastVisiblePart ||
         instance.overlap.area_px < kLeastVisiblePart * instance.predicted_px;
}

void StereoTracker::end(TrackInstance& instance) noexcept {
  instance.slot_state = TrackInstance::Slot::kEnded;
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
    if (instance.detection >= 0) {
      const Detection& detection = detections.left[static_cast<std::size_t>(instance.detection)];
      instance.track.box_px = detection.box_px;
      instance.track.area_px = detection.area_px;
      continue;
    }
    if (instance.track.missed_frames > config_.max_missed_frames) {
      // It waits to be seen again; what it would cover is a guess that may not take pixels from anything.
      instance.track.box_px = {};
      instance.track.area_px = 0;
      continue;
    }
    const LabelRegion shown = claim_free_pixels(prediction_, instance.track.label(), instance.overlap.box_px, left_);
    instance.track.box_px = shown.box_px;
    instance.track.area_px = shown.area_px;
  }
  // Only now are all pixels given away, so that hidden parts are known to be hidden.
  for (TrackInstance& instance : slots_) {
    if (instance.alive() && instance.detection >= 0) {
      remember_mask(instance, detections.left[static_cast<std::size_t>(instance.detection)]);
    }
  }
}

// The mask to predict from: the detected pixels, and those of the old mask that now lie behind a nearer object. So an
// object that passes behind another keeps its full shape and is recognised when any part of it comes out.
void StereoTracker::remember_mask(TrackInstance& instance, const Detection& detection) noexcept {
  const double fit =
      intersection_over_union(instance.overlap.on_label[detection.label], instance.overlap.area_px, detection.area_px);
  const bool cut_off = instance.forecast.known && instance.mask_part_in_image < kWholeInImage;
  const bool hidden = instance.overlap.area_px < kWholeInSight * instance.predicted_px;
  if ((cut_off || hidden) && fit > kStillFits) {
    return;
  }
  instance.mask_forecast = instance.forecast.known ? instance.forecast : direction_of(instance.track.box_px);
  const std::uint8_t label = instance.track.label();
  PixelBox box = instance.track.box_px;
  // A thing does not grow by being hidden: what was predicted wrongly would, frame by frame.
  const PixelBox predicted_box =
      common_part(instance.mask.current_box(), slid_to_hold(box, instance.mask.current_box()));
  const bool partly_hidden = instance.overlap.area_px < instance.predicted_px;
  if (!partly_hidden || predicted_box.empty()) {
    instance.mask.capture(left_, box, [&](std::uint8_t pixel, int, int) { return pixel == label; });
    return;
  }
  const auto hides = [&](std::uint8_t pixel) {
    return pixel != label && pixel != kBackgroundLabel && pixel <= slots_.size() && slots_[pixel - 1U].alive() &&
           nearer(slots_[pixel - 1U], instance);
  };
  instance.mask.for_each_pixel(predicted_box, [&](int x, int y) {
    std::uint8_t& pixel = prediction_.data[static_cast<std::ptrdiff_t>(y) * prediction_.stride + x];
    const std::uint8_t shown = left_.data[static_cast<std::ptrdiff_t>(y) * left_.stride + x];
    pixel = hides(shown) ? kIgnoreLabel : pixel;  // the prediction image is free to mark them in
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

void StereoTracker::publish() noexcept {
  published_.clear();
  for (TrackInstance& instance : slots_) {
    if (instance.alive()) {
      const double shown =
          instance.predicted_px > 0 ? static_cast<double>(instance.overlap.area_px) / instance.predicted_px : 0.0;
      const double part = instance.track.age_frames == 0 ? 1.0 : shown * instance.mask_part_in_image;
      instance.track.visible_part = static_cast<float>(std::min(part, 1.0));
      (void)published_.push_back(instance.track);  // as many places as slots
    }
  }
  std::sort(published_.begin(), published_.end(), [](const Track& a, const Track& b) { return a.id < b.id; });
}

}  // namespace kinetrace::tracking
