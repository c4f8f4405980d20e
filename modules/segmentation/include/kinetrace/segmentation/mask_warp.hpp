// Warps masks of an earlier frame to the present one.
#pragma once

#include <array>
#include <cstdint>
#include <span>

#include <Eigen/Core>

#include "kinetrace/core/arena.hpp"
#include "kinetrace/core/feature_frame.hpp"
#include "kinetrace/core/fixed_vector.hpp"
#include "kinetrace/core/image_view.hpp"
#include "kinetrace/core/instance_masks.hpp"
#include "kinetrace/core/stereo_geometry.hpp"
#include "kinetrace/segmentation/mask_canvas.hpp"
#include "kinetrace/segmentation/region_match.hpp"
#include "kinetrace/segmentation/seen_features.hpp"
#include "kinetrace/segmentation/segmenter.hpp"

namespace kinetrace::segmentation {

/// Features in a mask that were tracked since determine its motion: a shift and a scale, by least squares over those
/// that agree with the median shift. If too few agree, the images determine the shift, near that of the features
/// around.
class MaskWarp {
 public:
  MaskWarp() = default;
  /// `right`: masks of the right image are warped, too.
  MaskWarp(const StereoGeometry& geometry, int max_features, bool right, Arena& arena);

  /// Stores the images of the frame whose masks are expected.
  void remember(const RectifiedPair& pair) noexcept;
  /// Warps that frame's masks in `canvas` to the present frame. `then`: its features.
  void warp(std::span<const SeenFeature> then, const SegmentationInput& now, View view, MaskCanvas& canvas) noexcept;

 private:
  struct Motion {
    std::uint16_t mask = 0;  ///< Its value on the canvas.
    Eigen::Vector2f then_px{0.F, 0.F};
    Eigen::Vector2f now_px{0.F, 0.F};
  };
  /// now = then * scale + shift_px
  struct Similarity {
    float scale = 1.F;
    Eigen::Vector2f shift_px{0.F, 0.F};
  };
  /// Of one camera.
  struct Images {
    ImagePyramid earlier;
    ImagePyramid now;
  };

  [[nodiscard]] Images& images_of(View view) noexcept { return images_[view == View::kLeft ? 0 : 1]; }
  void collect(std::span<const SeenFeature> seen, std::span<const Feature> now, View view,
               ImageView<const std::uint16_t> drawn) noexcept;
  void find_boxes(ImageView<const std::uint16_t> drawn, std::size_t masks) noexcept;
  [[nodiscard]] Similarity motion_of(std::uint16_t mask, View view) noexcept;
  [[nodiscard]] Similarity motion_in_images(std::uint16_t mask, View view) noexcept;
  [[nodiscard]] Eigen::Vector2f shift_around(const PixelBox& box_px) noexcept;
  [[nodiscard]] Eigen::Vector2f median_shift(std::span<const Motion> motions) noexcept;
  void move(std::uint16_t mask, const Similarity& motion, ImageView<std::uint16_t> target) noexcept;

  FixedVector<Motion> motions_;
  FixedVector<Motion> chosen_;
  FixedVector<float> sorted_;
  FixedVector<PixelBox> boxes_px_;  ///< By mask, from 1.
  FixedVector<int> columns_;        ///< Of the earlier image, for the columns of a mask.
  ImageView<std::uint16_t> earlier_;
  bool has_right_ = false;
  std::array<Images, 2> images_;  ///< Left, and right if it has masks.
  RegionMatch match_;
  std::int64_t timestamp_ns_ = 0;  ///< Of the earlier images...
  float elapsed_s_ = 0.F;          ///< ... and the time since then.
};

}  // namespace kinetrace::segmentation
