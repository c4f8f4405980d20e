// One frame's images, and the left one of the frame before, in every form that features need.
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

  /// Copies the pair, the right image as one that stands as `correction` says is seen by one that stands as calibrated,
  /// and builds the left pyramid and both gradients; what was current becomes previous. `workers` may be null.
  void take_in(const RectifiedPair& pair, const RigCorrection& correction, Workers* workers) noexcept;

  [[nodiscard]] const ImagePyramid& current() const noexcept { return pyramids_[newest_]; }
  [[nodiscard]] const ImagePyramid& previous() const noexcept { return pyramids_[1 - newest_]; }
  /// The right image as it is used.
  [[nodiscard]] GrayView right() const noexcept { return right_.pixels(); }
  [[nodiscard]] StereoImages stereo() const noexcept {
    return {current().level(0), right_.plane(), left_gradient_.plane(), right_gradient_.plane()};
  }

 private:
  void take_in_left(GrayView image) noexcept;
  void take_in_right(const RectifiedPair& pair, const RigCorrection& correction) noexcept;
  void turn_right(const RectifiedPair& pair, const RigCorrection& correction) noexcept;

  ImagePyramid pyramids_[2];  ///< Left, of this and the previous frame in turn.
  int newest_ = 0;
  PaddedImage right_;
  PaddedImage left_gradient_;
  PaddedImage right_gradient_;
  std::span<std::uint16_t> scratch_;
  std::span<WarpNode> nodes_;  ///< Of one row.
};

}  // namespace kinetrace::features
