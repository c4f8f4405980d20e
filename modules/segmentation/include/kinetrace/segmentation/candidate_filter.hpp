// Candidates of a network that are too large for what they are said to be.
#pragma once

#include <cstdint>
#include <span>

#include "kinetrace/core/arena.hpp"
#include "kinetrace/core/fixed_vector.hpp"
#include "kinetrace/core/instance_masks.hpp"
#include "kinetrace/core/stereo_geometry.hpp"
#include "kinetrace/segmentation/seen_features.hpp"

namespace kinetrace::segmentation {

/// Rejects people who are larger than any: an open door, a part of a house. Their size follows from the box in the
/// image and the disparities of the features in the mask, of which the nearer ones count: some may lie behind the
/// person. A mask with few features is accepted.
class CandidateFilter {
 public:
  CandidateFilter() = default;
  CandidateFilter(const StereoGeometry& geometry, int max_features, Arena& arena);

  /// The plausible ones among the candidates in the left image of the frame of these features, in their order. The
  /// result lives until the next call.
  [[nodiscard]] std::span<const RunLengthMask> plausible(std::span<const RunLengthMask> candidates,
                                                         std::span<const SeenFeature> features) noexcept;

 private:
  /// A point in the box of a mask.
  struct Sample {
    std::uint32_t at = 0;  ///< Pixels of the box before it, row by row.
    float disparity_px = 0.F;
  };
  /// Upper quartile of the disparities in a mask; 0 = unknown.
  [[nodiscard]] float near_disparity_px(const RunLengthMask& mask, std::span<const SeenFeature> features) noexcept;

  float baseline_m_ = 0.F;
  FixedVector<Sample> samples_;
  FixedVector<float> inside_px_;  ///< Disparities.
  FixedVector<RunLengthMask> plausible_;
};

}  // namespace kinetrace::segmentation
