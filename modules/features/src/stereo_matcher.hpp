// Finds features of the left image in the right one.
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
  Plane left_gradient;  ///< Searched instead of gray: blind to offset, nearly so to gain.
  Plane right_gradient;
};

class StereoMatcher {
 public:
  StereoMatcher() = default;
  explicit StereoMatcher(const FeatureConfig& config) : config_(config) {}

  /// How the pairs that come were corrected. `rows_unknown`: matches may lie far off their row.
  void set_rig(const StereoGeometry& geometry, const RigCorrection& correction, bool rows_unknown) noexcept;

  /// Sets u_right_px and v_px of the slot's feature, NaN and the left row where there is no match. Looks near
  /// `expected_disparity_px` first if that is not negative, then everywhere.
  bool match(const StereoImages& images, float expected_disparity_px, FeatureSlot& slot) const noexcept;

  /// How far off its row a match may be.
  [[nodiscard]] float max_row_difference_px() const noexcept;

 private:
  /// Disparities [first, last].
  struct Range {
    int first = 0;
    int last = 0;
    [[nodiscard]] int count() const noexcept { return last - first + 1; }
  };
  [[nodiscard]] Range clipped(float from, float to, int x) const noexcept;
  /// Rows to look in, and how far off its own row a match may be.
  [[nodiscard]] std::span<const int> row_offsets(const Feature& feature) const noexcept;
  /// How far off its row it was before.
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
