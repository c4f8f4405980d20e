// One frame's images, and the left one of the frame before, in all forms used by features.
#pragma once

#include <cstdint>
#include <span>

#include "image_pyramid.hpp"
#include "kinetrace/core/arena.hpp"
#include "kinetrace/core/frame.hpp"
#include "kinetrace/core/rig_correction.hpp"
#include "kinetrace/core/workers.hpp"
#include "stereo_matcher.hpp"

namespace kinetrace::features {

class FrameImages {
 public:
  FrameImages() = default;
  FrameImages(Arena& arena, int width_px, int height_px, int pyramid_levels);

  /// Copies the pair, warping the right image by `correction` to that of a camera as calibrated, and builds the left
  /// pyramid and both gradients; current becomes previous. `workers` may be null.
  void take_in(const RectifiedPair& pair, const RigCorrection& correction, Workers* workers) noexcept;

  [[nodiscard]] const ImagePyramid& current() const noexcept { return pyramids_[newest_]; }
  [[nodiscard]] const ImagePyramid& previous() const noexcept { return pyramids_[1 - newest_]; }
  /// Right image, corrected.
  [[nodiscard]] GrayView right() const noexcept { return right_.pixels(); }
  [[nodiscard]] StereoImages stereo() const noexcept {
    return {current().level(0), right_.plane(), left_gradient_.plane(), right_gradient_.plane()};
  }

 private:
  void take_in_left(GrayView image) noexcept;
  void take_in_right(const RectifiedPair& pair, const RigCorrection& correction) noexcept;
  void turn_right(const RectifiedPair& pair, const RigCorrection& correction) noexcept;

  ImagePyramid pyramids_[2];  ///< Left, of this and the previous frame, alternating.
  int newest_ = 0;
  PaddedImage right_;
  PaddedImage left_gradient_;
  PaddedImage right_gradient_;
  std::span<std::uint16_t> scratch_;
  std::span<WarpNode> nodes_;  ///< Of one row.
};

}  // namespace kinetrace::features
