// Features of an earlier frame.
#pragma once

#include <cstdint>
#include <span>

#include <Eigen/Core>

#include "kinetrace/core/arena.hpp"
#include "kinetrace/core/feature_frame.hpp"
#include "kinetrace/core/fixed_vector.hpp"

namespace kinetrace::segmentation {

/// As it was then; full pixels.
struct SeenFeature {
  std::uint32_t id = 0;  ///< 0: none in this slot.
  Eigen::Vector2f left_px{0.F, 0.F};
  float u_right_px = kNoRight;  ///< NaN where unmatched.

  [[nodiscard]] bool has_right() const noexcept { return u_right_px == u_right_px; }
  [[nodiscard]] float disparity_px() const noexcept { return left_px.x() - u_right_px; }
};

/// The features of the frame whose masks are expected.
class SeenFeatures {
 public:
  SeenFeatures() = default;
  SeenFeatures(int max_features, Arena& arena);

  void remember(std::span<const Feature> features) noexcept;
  [[nodiscard]] std::span<const SeenFeature> by_slot() const noexcept { return by_slot_.span(); }

 private:
  FixedVector<SeenFeature> by_slot_;
};

}  // namespace kinetrace::segmentation
