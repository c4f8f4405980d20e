// Motion of a lost feature's neighbours, as an initial value for a second attempt.
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
  /// Adds a tracked feature.
  void add(const FeatureSlot& slot) noexcept;
  /// Adds a feature whose tracking failed.
  void postpone(const Feature& feature, TrackOutcome outcome) noexcept;
  [[nodiscard]] std::span<const Postponed> postponed() const noexcept { return postponed_.span(); }

  /// True if most features of the body were tracked at the first attempt: its predictions are right, and the tracked
  /// features predict the others. Otherwise the few tracked ones may well be outliers.
  [[nodiscard]] bool trustworthy(std::uint8_t body) const noexcept { return followed_[body] > failed_[body]; }

  /// Expected position of `feature`: the median over the few nearest tracked features of the same body, each by its own
  /// motion and zoom. False without near ones.
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
