// Matches features of the left image with the right one.
#pragma once

#include <array>
#include <cstdint>
#include <span>

#include "feature_slot.hpp"
#include "image_pyramid.hpp"
#include "kinetrace/core/arena.hpp"
#include "kinetrace/core/rig_correction.hpp"
#include "kinetrace/features/feature_config.hpp"

namespace kinetrace::features {

/// One frame's images, left and right.
struct StereoImages {
  Plane left;
  Plane right;
  Plane left_gradient;  ///< Searched instead of gray: invariant to offset, nearly to gain.
  Plane right_gradient;
};

class StereoMatcher {
 public:
  StereoMatcher() = default;
  explicit StereoMatcher(const FeatureConfig& config) : config_(config) {}

  /// Sets the correction of the following pairs. `rows_unknown`: matches may lie far off their row.
  void set_rig(const StereoGeometry& geometry, const RigCorrection& correction, bool rows_unknown) noexcept;

  /// Sets u_right_px and v_px of the slot's feature; without a match to NaN and the left row. Searches near
  /// `expected_disparity_px` first if that is not negative, then the whole range.
  bool match(const StereoImages& images, float expected_disparity_px, FeatureSlot& slot) const noexcept;

  /// Largest distance of a match from its row.
  [[nodiscard]] float max_row_difference_px() const noexcept;

 private:
  /// Disparities [first, last].
  struct Range {
    int first = 0;
    int last = 0;
    [[nodiscard]] int count() const noexcept { return last - first + 1; }
  };
  [[nodiscard]] Range clipped(float from, float to, int x) const noexcept;
  /// Rows to search, relative to the feature's own.
  [[nodiscard]] std::span<const int> row_offsets(const Feature& feature) const noexcept;
  /// Row difference of the feature's last match.
  [[nodiscard]] int known_row_offset(const Feature& feature) const noexcept;
  [[nodiscard]] bool search(const StereoImages& images, const Feature& feature, Range range, int row_offset,
                            bool unique, int& disparity) const noexcept;
  [[nodiscard]] bool refine(const StereoImages& images, int disparity, int row_offset, int passes,
                            FeatureSlot& slot) const noexcept;

  FeatureConfig config_;
  StereoGeometry geometry_;
  RigCorrection correction_;
  bool rows_unknown_ = false;
};

}  // namespace kinetrace::features
