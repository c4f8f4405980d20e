#include "kinetrace/features/feature_front_end.hpp"

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>

#include "feature_follower.hpp"
#include "feature_population.hpp"
#include "feature_slot.hpp"
#include "frame_images.hpp"
#include "kernels.hpp"
#include "stereo_matcher.hpp"

namespace kinetrace::features {
namespace {

constexpr int kMinWidth = 64;
constexpr int kMinHeight = 48;

enum class Step : std::uint8_t { kNeedsFrame, kNeedsTrack, kNeedsReplenish };

std::string size_text(int width, int height) {
  return std::to_string(width) + " x " + std::to_string(height);
}

}  // namespace

/// All state, in the arena. Trivially destructible: it owns nothing.
struct FeatureFrontEnd::State {
  Workers* workers = nullptr;
  int width_px = 0;
  int height_px = 0;
  FeatureFollower follower;
  StereoMatcher matcher;
  FeaturePopulation population;
  FrameImages images;

  std::span<FeatureSlot> slots;
  FixedVector<Feature> published;
  std::int64_t frame_index = 0;
  std::int64_t timestamp_ns = 0;
  Step step = Step::kNeedsFrame;
  FeatureCounters counters;

  [[nodiscard]] static State carve(const FeatureConfig& config, int width_px, int height_px, Arena& arena);
  [[nodiscard]] const ImagePyramid& current() const noexcept { return images.current(); }

  std::uint64_t attempted_before = 0;  ///< Counters at the frame before.
  std::uint64_t matched_before = 0;
  double usual_match_ratio = 0.0;
  int row_search_frames = 0;  ///< Since it began; 0: inactive.

  void take_in(const RectifiedPair& pair, const RigAdjustment& rig) noexcept;
  /// Converts the measurements of the frame before.
  void remeasure(const RigChange& change) noexcept;
  [[nodiscard]] float row_difference_px() const noexcept;
  [[nodiscard]] bool should_search_rows(const RigAdjustment& rig) noexcept;
  void end_rejected() noexcept;
  void remember_previous() noexcept;
  void follow_others_and_match(std::span<const FeaturePrediction> by_slot) noexcept;
  /// Matches the features in these slots with the right image.
  void match(std::span<const std::uint16_t> in_slots, std::span<const FeaturePrediction> by_slot) noexcept;
  void share_matching(std::span<const std::uint16_t> in_slots, std::span<const FeaturePrediction> by_slot) noexcept;
  void count_matches(std::span<const std::uint16_t> in_slots) noexcept;
  /// Creates features, with their right matches.
  void create_features(LabelView labels, const PredictedMasks& predicted_masks) noexcept;
  [[nodiscard]] FeatureFrame publish() noexcept;
};

FeatureFrontEnd::State FeatureFrontEnd::State::carve(const FeatureConfig& config, int width_px, int height_px,
                                                     Arena& arena) {
  const auto capacity = static_cast<std::size_t>(config.max_features);
  State state;
  state.width_px = width_px;
  state.height_px = height_px;
  state.follower = FeatureFollower(config, arena);
  state.matcher = StereoMatcher(config);
  state.population = FeaturePopulation(config, arena, width_px, height_px);
  state.images = FrameImages(arena, width_px, height_px, config.pyramid_levels);
  state.slots = arena.take<FeatureSlot>(capacity);
  state.published = FixedVector<Feature>(arena, capacity);
  return state;
}

std::size_t FeatureFrontEnd::required_bytes(const FeatureConfig& config, int width_px, int height_px) {
  return measure_bytes([&](Arena& arena) {
    static_cast<void>(State::carve(config, width_px, height_px, arena));
    static_cast<void>(arena.take<State>(1));
  });
}

Result<FeatureFrontEnd> FeatureFrontEnd::create(const FeatureConfig& config, int width_px, int height_px, Arena& arena,
                                                Workers* workers) {
  if (Status valid = config.validate(); !valid) {
    return Unexpected(std::move(valid.error()));
  }
  if (width_px < kMinWidth || height_px < kMinHeight) {
    return fail(ErrorCode::kInvalidArgument, "features: images of " + size_text(width_px, height_px) +
                                                 " pixels are too small; at least " + size_text(kMinWidth, kMinHeight) +
                                                 " are needed");
  }
  State state = State::carve(config, width_px, height_px, arena);
  const std::span<State> home = arena.take<State>(1);
  if (home.empty()) {
    return fail(ErrorCode::kCapacity, "features: the arena does not hold the " +
                                          std::to_string(required_bytes(config, width_px, height_px)) +
                                          " bytes needed; raise the memory budget or lower features.max_features");
  }
  state.workers = workers;
  home[0] = state;
  return FeatureFrontEnd(home[0]);
}

Status FeatureFrontEnd::begin_frame(const RectifiedPair& pair, const RigAdjustment& rig) {
  for (const GrayView& image : {pair.left, pair.right}) {
    if (image.empty() || image.width != state_->width_px || image.height != state_->height_px) {
      return fail(ErrorCode::kInvalidArgument, "features: frame " + std::to_string(pair.frame_index) + " measures " +
                                                   size_text(image.width, image.height) + " pixels, expected " +
                                                   size_text(state_->width_px, state_->height_px));
    }
  }
  state_->take_in(pair, rig);
  state_->step = Step::kNeedsTrack;
  return {};
}

Result<FeatureFrame> FeatureFrontEnd::track(std::span<const FeaturePrediction> by_slot) {
  if (state_->step != Step::kNeedsTrack) {
    return fail(ErrorCode::kIllegalState, "features: track needs begin_frame before it");
  }
  state_->end_rejected();
  state_->remember_previous();
  state_->follower.follow_predicted(state_->images.previous(), state_->current(), by_slot, state_->slots,
                                    state_->counters, state_->workers);
  state_->follow_others_and_match(by_slot);
  state_->step = Step::kNeedsReplenish;
  return state_->publish();
}

GrayView FeatureFrontEnd::right_image() const noexcept {
  return state_->images.right();
}

bool FeatureFrontEnd::row_search_began() const noexcept {
  return state_->row_search_frames == 1;
}

std::size_t FeatureFrontEnd::count_corners() noexcept {
  return state_->population.count_corners(state_->current().level(0), state_->workers);
}

Result<FeatureFrame> FeatureFrontEnd::replenish(LabelView left_labels, const PredictedMasks& predicted_masks) {
  if (state_->step != Step::kNeedsReplenish) {
    return fail(ErrorCode::kIllegalState, "features: replenish needs track before it");
  }
  if (!left_labels.empty() && (left_labels.width != state_->width_px || left_labels.height != state_->height_px)) {
    return fail(ErrorCode::kInvalidArgument, "features: labels measure " +
                                                 size_text(left_labels.width, left_labels.height) +
                                                 " pixels, expected " + size_text(state_->width_px, state_->height_px));
  }
  state_->population.reconcile_with(left_labels, state_->slots, state_->counters);
  state_->population.thin_out(state_->slots, state_->counters);
  state_->population.mask_patches(left_labels, state_->slots, state_->workers);
  state_->create_features(left_labels, predicted_masks);
  state_->step = Step::kNeedsFrame;
  return state_->publish();
}

void FeatureFrontEnd::reject(std::span<const std::uint16_t> slots) noexcept {
  for (const std::uint16_t slot : slots) {
    if (slot < state_->slots.size() && state_->slots[slot].state == SlotState::kAlive) {
      state_->slots[slot].rejected = true;
    }
  }
}

void FeatureFrontEnd::limit(double part) noexcept {
  state_->population.limit(part);
}

const FeatureCounters& FeatureFrontEnd::counters() const noexcept {
  return state_->counters;
}

void FeatureFrontEnd::reset() noexcept {
  for (FeatureSlot& slot : state_->slots) {
    slot.state = SlotState::kFree;
  }
  state_->published.clear();
  state_->counters = {};
  state_->attempted_before = 0;
  state_->matched_before = 0;
  state_->step = Step::kNeedsFrame;
}

/// Mean over the matches of the frame before; 0 if there are too few.
float FeatureFrontEnd::State::row_difference_px() const noexcept {
  constexpr float kMinMatches = 20.F;
  float sum_px = 0.F;
  float count = 0.F;
  for (const FeatureSlot& slot : slots) {
    if (slot.state == SlotState::kAlive && slot.feature.has_right()) {
      sum_px += 2.F * std::abs(slot.feature.v_px - slot.feature.left_px.y());
      count += 1.F;
    }
  }
  return count >= kMinMatches ? sum_px / count : 0.F;
}

// If hardly any feature matches, or the matches lie so far off their row that others must be beyond the limit, the
// calibration's rows may be wrong. The search of other rows takes time, so it ends with the next correction, or after a
// while without one.
bool FeatureFrontEnd::State::should_search_rows(const RigAdjustment& rig) noexcept {
  constexpr std::uint64_t kMinAttempts = 100;
  constexpr double kFewMatched = 0.3;
  constexpr double kFewOfUsual = 0.7;
  constexpr double kUsualGain = 0.1;
  constexpr float kPartOfLimit = 0.4F;  // Mean of a normal distribution whose 5 % lie beyond the limit.
  constexpr int kFramesOfSearch = 20;
  constexpr int kFramesOfRest = 100;
  const std::uint64_t attempted = counters.stereo_attempted - attempted_before;
  const std::uint64_t matched = counters.stereo_matched - matched_before;
  attempted_before = counters.stereo_attempted;
  matched_before = counters.stereo_matched;
  if (!rig.may_be_off || rig.change != nullptr) {
    row_search_frames = 0;
    return false;
  }
  const double ratio = attempted > 0 ? static_cast<double>(matched) / static_cast<double>(attempted) : 0.0;
  const bool few = (attempted >= kMinAttempts && ratio < std::max(kFewMatched, kFewOfUsual * usual_match_ratio)) ||
                   (row_search_frames == 0 && row_difference_px() > kPartOfLimit * matcher.max_row_difference_px());
  if (!few) {
    usual_match_ratio += kUsualGain * (ratio - usual_match_ratio);
  }
  if (row_search_frames > 0 || few) {
    row_search_frames = (row_search_frames + 1) % (kFramesOfSearch + kFramesOfRest);
  }
  return row_search_frames > 0 && row_search_frames <= kFramesOfSearch;
}

void FeatureFrontEnd::State::take_in(const RectifiedPair& pair, const RigAdjustment& rig) noexcept {
  frame_index = pair.frame_index;
  timestamp_ns = pair.timestamp_ns;
  images.take_in(pair, rig.correction, workers);
  matcher.set_rig(pair.geometry, rig.correction, should_search_rows(rig));
  if (rig.change != nullptr) {
    remeasure(*rig.change);
  }
  for (FeatureSlot& slot : slots) {
    if (slot.state == SlotState::kDead) {
      slot.state = SlotState::kFree;
    }
  }
}

void FeatureFrontEnd::State::remeasure(const RigChange& change) noexcept {
  for (FeatureSlot& slot : slots) {
    Feature& feature = slot.feature;
    if (slot.state != SlotState::kAlive || !feature.has_right()) {
      continue;
    }
    const Eigen::Vector2d before(feature.u_right_px, 2.F * feature.v_px - feature.left_px.y());
    const Eigen::Vector2f now = change.right_px(before, static_cast<double>(feature.disparity_px())).cast<float>();
    feature.u_right_px = now.x();
    feature.v_px = 0.5F * (feature.left_px.y() + now.y());
  }
}

void FeatureFrontEnd::State::end_rejected() noexcept {
  for (FeatureSlot& slot : slots) {
    if (slot.state == SlotState::kAlive && slot.rejected) {
      slot.end(counters.rejected);
    }
  }
}

void FeatureFrontEnd::State::remember_previous() noexcept {
  for (FeatureSlot& slot : slots) {
    slot.feature.previous_left_px = slot.feature.left_px;
    slot.feature.previous_v_px = slot.feature.v_px;
    slot.feature.previous_u_right_px = slot.feature.u_right_px;
  }
}

// Features found as predicted are matched while the others are tracked, which depend on each other.
void FeatureFrontEnd::State::follow_others_and_match(std::span<const FeaturePrediction> by_slot) noexcept {
  const std::span<const std::uint16_t> found = follower.found();
  const std::size_t groups = (found.size() + kFeaturesAtOnce - 1) / kFeaturesAtOnce;
  in_pieces(workers, 1 + groups, 1, [&](std::size_t begin, std::size_t end) {
    for (std::size_t piece = begin; piece < end; ++piece) {
      if (piece == 0) {
        follower.follow_others(images.previous(), current(), by_slot, slots, counters);
      } else {
        const std::size_t first = (piece - 1) * kFeaturesAtOnce;
        match(found.subspan(first, std::min(kFeaturesAtOnce, found.size() - first)), by_slot);
      }
    }
  });
  share_matching(follower.found().subspan(found.size()), by_slot);
  count_matches(follower.found());
}

void FeatureFrontEnd::State::share_matching(std::span<const std::uint16_t> in_slots,
                                            std::span<const FeaturePrediction> by_slot) noexcept {
  in_pieces(workers, in_slots.size(), kFeaturesAtOnce,
            [&](std::size_t begin, std::size_t end) { match(in_slots.subspan(begin, end - begin), by_slot); });
}

void FeatureFrontEnd::State::match(std::span<const std::uint16_t> in_slots,
                                   std::span<const FeaturePrediction> by_slot) noexcept {
  const StereoImages stereo = images.stereo();
  for (const std::uint16_t i : in_slots) {
    const Feature& feature = slots[i].feature;
    const float before = feature.had_right() ? feature.previous_left_px.x() - feature.previous_u_right_px : -1.F;
    const bool predicted = i < by_slot.size() && by_slot[i].known && by_slot[i].disparity_px >= 0.F;
    static_cast<void>(matcher.match(stereo, predicted ? by_slot[i].disparity_px : before, slots[i]));
  }
}

void FeatureFrontEnd::State::count_matches(std::span<const std::uint16_t> in_slots) noexcept {
  counters.stereo_attempted += in_slots.size();
  counters.stereo_matched += static_cast<std::uint64_t>(std::count_if(
      in_slots.begin(), in_slots.end(), [this](std::uint16_t slot) { return slots[slot].feature.has_right(); }));
}

void FeatureFrontEnd::State::create_features(LabelView labels, const PredictedMasks& predicted_masks) noexcept {
  const std::span<const std::uint16_t> created =
      population.create(current().level(0), labels, predicted_masks, slots, counters, workers);
  // No predictions for new features.
  share_matching(created, {});
  count_matches(created);
  for (const std::uint16_t index : created) {
    Feature& feature = slots[index].feature;
    feature.previous_v_px = feature.v_px;
  }
}

FeatureFrame FeatureFrontEnd::State::publish() noexcept {
  const Plane image = current().level(0);
  published.clear();
  for (FeatureSlot& slot : slots) {
    if (slot.state != SlotState::kAlive) {
      continue;
    }
    const auto x = std::clamp(static_cast<int>(std::lround(slot.feature.left_px.x())), 0, image.width - 1);
    const auto y = std::clamp(static_cast<int>(std::lround(slot.feature.left_px.y())), 0, image.height - 1);
    slot.feature.intensity = image.data[static_cast<std::ptrdiff_t>(y) * image.stride + x];
    // Capacity is the number of slots.
    static_cast<void>(published.push_back(slot.feature));
  }
  return {frame_index, timestamp_ns, published.span()};
}

}  // namespace kinetrace::features
