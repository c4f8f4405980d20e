// From features to pixels: which part of the image a moving region covers.
#pragma once

#include <array>
#include <cstdint>
#include <span>

#include <Eigen/Core>

#include "kinetrace/core/arena.hpp"
#include "kinetrace/core/detections.hpp"
#include "kinetrace/core/feature_frame.hpp"
#include "kinetrace/core/fixed_vector.hpp"
#include "kinetrace/core/image_view.hpp"
#include "kinetrace/core/stereo_geometry.hpp"
#include "kinetrace/segmentation/motion_evidence.hpp"
#include "kinetrace/segmentation/motion_memory.hpp"

namespace kinetrace::segmentation {

/// Draws each reported region as the convex hull of its features on a grid of 4x4 pixels, widened by a margin of about
/// .25 m around features that were seen to move (the others were found on an earlier mask, which had that margin). A
/// cell belongs to the region only if one of its features is nearer than any feature that is seen to be
/// something else (it moves differently, or, for a region at rest, lies at another depth). Nearer regions cover farther
/// ones.
class RegionMask {
 public:
  static constexpr int kCellPx = 4;

  RegionMask() = default;
  RegionMask(const StereoGeometry& geometry, int max_features, int max_objects, int min_area_px, Arena& arena);

  /// Returns how many regions were dropped: beyond max_objects (the smallest hulls) or below min_area_px.
  int draw(std::span<const Feature> features, std::span<const FeatureMotion> motions, MotionMemory& memory);

  /// For each feature that is new and lies on a tracked body: id of the region drawn, in the previous frame, where it
  /// was found; 0 otherwise. The result lives until the next call.
  std::span<const std::uint32_t> inherited_regions(std::span<const Feature> features);

  [[nodiscard]] LabelView labels() const noexcept { return labels_; }
  /// Largest hull first; class unknown.
  [[nodiscard]] std::span<const Detection> detections() const noexcept { return detections_.span(); }

 private:
  struct Outline {
    std::int16_t region = -1;
    std::uint8_t label = 0;
    float area_px = 0.F;
    float disparity_px = 0.F;
    int members = 0;
  };

  void trace_outlines(std::span<const Feature> features, MotionMemory& memory);
  void take_members(const Outline& outline, std::span<const Feature> features, const MotionMemory& memory);
  void take_others(const Outline& outline, std::span<const Feature> features, std::span<const FeatureMotion> motions,
                   const MotionMemory& memory);
  void build_hull();
  void fill(const Outline& outline);
  void find_nearest_seeds(const PixelBox& cells);
  [[nodiscard]] std::int16_t& nearest_seed(int cx, int cy) const noexcept {
    return nearest_seed_[static_cast<std::size_t>(cy) * static_cast<std::size_t>(grid_width_) +
                         static_cast<std::size_t>(cx)];
  }
  [[nodiscard]] static Eigen::Vector2f cell_center(int cx, int cy) noexcept {
    constexpr float kHalf = 0.5F * (kCellPx - 1);
    return {static_cast<float>(cx * kCellPx) + kHalf, static_cast<float>(cy * kCellPx) + kHalf};
  }
  void measure();
  [[nodiscard]] float margin_px(const Outline& outline) const noexcept;

  static constexpr std::int16_t kNoSeed = -1;

  StereoGeometry geometry_;
  int min_area_px_ = 0;
  int grid_width_ = 0;
  int grid_height_ = 0;
  MutableLabelView labels_;
  FixedVector<Detection> detections_;
  FixedVector<Outline> outlines_;
  std::array<std::uint32_t, kMaxObjects + 1> region_of_label_{};
  FixedVector<std::uint32_t> inherited_;
  FixedVector<Eigen::Vector2f> members_;
  FixedVector<Eigen::Vector2f> rim_;  ///< Members, widened by the margin.
  FixedVector<Eigen::Vector2f> others_;
  FixedVector<Eigen::Vector2f> hull_;
  std::span<std::int16_t> nearest_seed_;  ///< Per cell of the region being drawn.
  std::span<float> scratch_;
};

}  // namespace kinetrace::segmentation
