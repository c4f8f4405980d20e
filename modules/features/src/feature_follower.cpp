#include "feature_follower.hpp"

namespace kinetrace::features {
namespace {

enum class Attempt : std::uint8_t { kFirst, kSecond };

/// Image size is proportional to disparity: both are inverse to depth.
float predicted_zoom(const Feature& feature, const FeaturePrediction& prediction) noexcept {
  // From this disparity on a tenth of a pixel of noise hardly matters; a larger factor is an error.
  constexpr float kMinDisparity_px = 4.F;
  constexpr float kMaxZoom = 2.F;
  const float before_px = feature.previous_left_px.x() - feature.previous_u_right_px;
  if (!feature.had_right() || before_px < kMinDisparity_px || !(prediction.disparity_px >= kMinDisparity_px)) {
    return 1.F;
  }
  const float zoom = prediction.disparity_px / before_px;
  return zoom > 1.F / kMaxZoom && zoom < kMaxZoom ? zoom : 1.F;
}

/// Null without a prediction.
const FeaturePrediction* prediction(const FeatureSlot& slot, std::span<const FeaturePrediction> by_slot) noexcept {
  const std::size_t index = slot.feature.slot;
  return index < by_slot.size() && by_slot[index].known ? &by_slot[index] : nullptr;
}

/// Tracking of one frame.
struct FramePass {
  const TemporalTracker& tracker;
  MotionNeighbours& neighbours;
  FixedVector<std::uint16_t>& found;
  const ImagePyramid& previous;
  const ImagePyramid& current;
  FeatureCounters& counters;

  TrackOutcome follow(FeatureSlot& slot, const TrackStart& start) const noexcept {
    return tracker.follow(previous, current, start, slot);
  }

  TrackOutcome follow_predicted(FeatureSlot& slot, const FeaturePrediction& prediction, Reach reach) const noexcept {
    return follow(slot, {prediction.left_px, reach, predicted_zoom(slot.feature, prediction)});
  }

  TrackOutcome follow_neighbours(FeatureSlot& slot) const noexcept {
    TrackStart start;
    return neighbours.trustworthy(slot.feature.body) && neighbours.expected(slot.feature, start)
               ? follow(slot, start)
               : TrackOutcome::kResidual;
  }

  TrackOutcome search_for(FeatureSlot& slot) const noexcept {
    return follow(slot, {slot.feature.left_px, Reach::kSearch, 1.F});
  }

  TrackOutcome follow_unpredicted(FeatureSlot& slot) const noexcept {
    const TrackOutcome outcome = follow_neighbours(slot);
    return succeeded(outcome) ? outcome : search_for(slot);
  }

  TrackOutcome follow_mispredicted(FeatureSlot& slot, const FeaturePrediction& prediction) const noexcept {
    // With all neighbours found as predicted, a wide search mostly finds mismatches.
    if (neighbours.trustworthy(slot.feature.body)) {
      const TrackOutcome outcome = follow_neighbours(slot);
      return succeeded(outcome) || slot.feature.age_frames > 0 ? outcome : search_for(slot);
    }
    // The predictions of the whole body are off, slightly or entirely.
    const TrackOutcome outcome = follow_predicted(slot, prediction, Reach::kWide);
    return succeeded(outcome) ? outcome : search_for(slot);
  }

  void conclude(FeatureSlot& slot, TrackOutcome outcome, Attempt attempt) const noexcept {
    if (succeeded(outcome)) {
      counters.recovered += attempt == Attempt::kSecond ? 1U : 0U;
      neighbours.add(slot);
      static_cast<void>(found.push_back(slot.feature.slot));  // As many places as slots.
      count(slot, outcome);
    } else if (attempt == Attempt::kFirst) {
      neighbours.postpone(slot.feature, outcome);
    } else {
      count(slot, outcome);
    }
  }

  void count(FeatureSlot& slot, TrackOutcome outcome) const noexcept {
    switch (outcome) {
      case TrackOutcome::kReReferenced: ++counters.re_referenced; [[fallthrough]];
      case TrackOutcome::kTracked:
        ++counters.tracked;
        ++slot.feature.age_frames;
        break;
      case TrackOutcome::kOutside: slot.end(counters.lost_outside); break;
      case TrackOutcome::kTexture: slot.end(counters.lost_texture); break;
      case TrackOutcome::kResidual: slot.end(counters.lost_residual); break;
      case TrackOutcome::kForwardBackward: slot.end(counters.lost_forward_backward); break;
    }
  }
};

}  // namespace

void FeatureFollower::follow_predicted(const ImagePyramid& previous, const ImagePyramid& current,
                                       std::span<const FeaturePrediction> by_slot, std::span<FeatureSlot> slots,
                                       FeatureCounters& counters, Workers* workers) noexcept {
  neighbours_.clear();
  predicted_.clear();
  unpredicted_.clear();
  found_.clear();
  for (const FeatureSlot& slot : slots) {
    // As many places as slots.
    if (slot.state == SlotState::kAlive && prediction(slot, by_slot) != nullptr) {
      static_cast<void>(predicted_.push_back({slot.feature.slot}));
    } else if (slot.state == SlotState::kAlive) {
      static_cast<void>(unpredicted_.push_back(slot.feature.slot));
    }
  }
  const FramePass pass{tracker_, neighbours_, found_, previous, current, counters};
  in_pieces(workers, predicted_.size(), kFeaturesAtOnce, [&](std::size_t begin, std::size_t end) {
    for (Followed& followed : predicted_.span().subspan(begin, end - begin)) {
      FeatureSlot& slot = slots[followed.slot];
      followed.outcome = pass.follow_predicted(slot, *prediction(slot, by_slot), Reach::kNear);
    }
  });
  for (const Followed& followed : predicted_.span()) {
    pass.conclude(slots[followed.slot], followed.outcome, Attempt::kFirst);
  }
}

void FeatureFollower::follow_others(const ImagePyramid& previous, const ImagePyramid& current,
                                    std::span<const FeaturePrediction> by_slot, std::span<FeatureSlot> slots,
                                    FeatureCounters& counters) noexcept {
  const FramePass pass{tracker_, neighbours_, found_, previous, current, counters};
  // Tracked features now predict the motion of the others.
  for (const std::uint16_t index : unpredicted_.span()) {
    pass.conclude(slots[index], pass.follow_unpredicted(slots[index]), Attempt::kFirst);
  }
  for (const MotionNeighbours::Postponed& failed : neighbours_.postponed()) {
    FeatureSlot& slot = slots[failed.slot];
    const FeaturePrediction* const predicted = prediction(slot, by_slot);
    const TrackOutcome second =
        predicted != nullptr ? pass.follow_mispredicted(slot, *predicted) : TrackOutcome::kResidual;
    // Report the reason of the first failure, not that of the long shot.
    pass.conclude(slot, succeeded(second) ? second : failed.outcome, Attempt::kSecond);
  }
}

}  // namespace kinetrace::features
