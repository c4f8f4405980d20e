// Tracks all features of a frame: first those with a prediction, then the others by their neighbours' motion.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "feature_slot.hpp"
#include "image_pyramid.hpp"
#include "kinetrace/core/arena.hpp"
#include "kinetrace/core/feature_frame.hpp"
#include "kinetrace/core/fixed_vector.hpp"
#include "kinetrace/core/workers.hpp"
#include "kinetrace/features/feature_config.hpp"
#include "kinetrace/features/feature_front_end.hpp"
#include "motion_neighbours.hpp"
#include "temporal_tracker.hpp"

namespace kinetrace::features {

class FeatureFollower {
 public:
  FeatureFollower() = default;
  FeatureFollower(const FeatureConfig& config, Arena& arena)
      : tracker_(config),
        neighbours_(arena, static_cast<std::size_t>(config.max_features)),
        predicted_(arena, static_cast<std::size_t>(config.max_features)),
        unpredicted_(arena, static_cast<std::size_t>(config.max_features)),
        found_(arena, static_cast<std::size_t>(config.max_features)) {}

  /// Tracks live features with a prediction from `previous` to `current`; failed ones are postponed.
  void follow_predicted(const ImagePyramid& previous, const ImagePyramid& current,
                        std::span<const FeaturePrediction> by_slot, std::span<FeatureSlot> slots,
                        FeatureCounters& counters, Workers* workers) noexcept;
  /// Then tracks, or ends, all other live features. Slots found already are skipped.
  void follow_others(const ImagePyramid& previous, const ImagePyramid& current,
                     std::span<const FeaturePrediction> by_slot, std::span<FeatureSlot> slots,
                     FeatureCounters& counters) noexcept;
  /// Slots of this frame's features so far; follow_others() adds to them.
  [[nodiscard]] std::span<const std::uint16_t> found() const noexcept { return found_.span(); }

 private:
  struct Followed {
    std::uint16_t slot = 0;
    TrackOutcome outcome = TrackOutcome::kResidual;
  };

  TemporalTracker tracker_;
  MotionNeighbours neighbours_;
  FixedVector<Followed> predicted_;  ///< Features with a prediction, and the outcome.
  FixedVector<std::uint16_t> unpredicted_;
  FixedVector<std::uint16_t> found_;
};

}  // namespace kinetrace::features
