// Candidates of a network that are too large for what they are said to be.
#pragma once

#include <cstdint>
#include <span>

#include <Eigen/Core>

#include "kinetrace/core/arena.hpp"
#include "kinetrace/core/feature_frame.hpp"
#include "kinetrace/core/fixed_vector.hpp"
#include "kinetrace/core/instance_masks.hpp"
#include "kinetrace/core/stereo_geometry.hpp"

namespace kinetrace::segmentation {

/// Rejects people who are larger than any: an open door, a part of a house. Their size follows from the box in the
/// image and the disparities of the features in the mask, of which the nearer ones count: some may lie behind the
/// person. A mask with few features is accepted.
class CandidateFilter {
 public:
  CandidateFilter() = default;
  CandidateFilter(const StereoGeometry& geometry, int max_features, Arena& arena);

  /// Stores the features of the frame whose masks are expected.
  void remember(std::span<const Feature> features) noexcept;
  /// The plausible ones among that frame's candidates in the left image, in their order. The result lives until the
  /// next call.
  [[nodiscard]] std::span<const RunLengthMask> plausible(std::span<const RunLengthMask> candidates) noexcept;

 private:
  struct Point {
    Eigen::Vector2i pixel{0, 0};
    float disparity_px = 0.F;
  };
  /// A point in the box of a mask.
  struct Sample {
    std::uint32_t at = 0;  ///< Pixels of the box before it, row by row.
    float disparity_px = 0.F;
  };
  /// Upper quartile of the disparities in a mask; 0 = unknown.
  [[nodiscard]] float near_disparity_px(const RunLengthMask& mask) noexcept;

  float baseline_m_ = 0.F;
  FixedVector<Point> points_;
  FixedVector<Sample> samples_;
  FixedVector<float> inside_px_;  ///< Disparities.
  FixedVector<RunLengthMask> plausible_;
};

}  // namespace kinetrace::segmentation
