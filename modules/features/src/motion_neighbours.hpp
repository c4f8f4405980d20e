// How the surroundings of a lost feature moved, as a second start for it.
#pragma once

#include <array>
#include <cstdint>
#include <span>

#include <Eigen/Core>

#include "kinetrace/core/arena.hpp"
#include "kinetrace/core/feature_frame.hpp"
#include "kinetrace/core/fixed_vector.hpp"
#include "temporal_tracker.hpp"

namespace kinetrace::features {

class MotionNeighbours {
 public:
  struct Postponed {
    std::uint16_t slot = 0;
    TrackOutcome outcome = TrackOutcome::kResidual;  ///< Why the first attempt failed.
  };

  MotionNeighbours() = default;
  MotionNeighbours(Arena& arena, std::size_t capacity) : moved_(arena, capacity), postponed_(arena, capacity) {}

  void clear() noexcept;
  /// A feature that was followed.
  void add(const FeatureSlot& slot) noexcept;
  /// A feature that was not.
  void postpone(const Feature& feature, TrackOutcome outcome) noexcept;
  [[nodiscard]] std::span<const Postponed> postponed() const noexcept { return postponed_.span(); }

  /// Most features of the body were followed at the first attempt: its predictions are right, and who was followed
  /// shows where the others went. Otherwise the few that seem to have been followed may well be wrong, too.
  [[nodiscard]] bool trustworthy(std::uint8_t body) const noexcept { return followed_[body] > failed_[body]; }

  /// Where `feature` may be now: the median of what the few nearest followed features of the same body say, each by its
  /// own motion and zoom. False when there is none near.
  [[nodiscard]] bool expected(const Feature& feature, TrackStart& start) const noexcept;

 private:
  struct Moved {
    Eigen::Vector2f from{0.F, 0.F};
    Eigen::Vector2f to{0.F, 0.F};
    float zoom = 1.F;
    std::uint8_t body = 0;
  };
  FixedVector<Moved> moved_;
  FixedVector<Postponed> postponed_;
  std::array<int, 256> followed_{};
  std::array<int, 256> failed_{};
};

}  // namespace kinetrace::features
