// One frame's images, and the left one of the frame before, in every form that features need.
#pragma once

#include <cstdint>
#include <span>

#include "image_pyramid.hpp"
#include "kinetrace/core/arena.hpp"
#include "kinetrace/core/frame.hpp"
#include "kinetrace/core/workers.hpp"
#include "stereo_matcher.hpp"

namespace kinetrace::features {

class FrameImages {
 public:
  FrameImages() = default;
  FrameImages(Arena& arena, int width_px, int height_px, int pyramid_levels);

  /// Copies the pair and builds the left pyramid and both gradients; what was current becomes previous. `workers` may
  /// be null.
  void take_in(const RectifiedPair& pair, Workers* workers) noexcept;

  [[nodiscard]] const ImagePyramid& current() const noexcept { return pyramids_[newest_]; }
  [[nodiscard]] const ImagePyramid& previous() const noexcept { return pyramids_[1 - newest_]; }
  [[nodiscard]] StereoImages stereo() const noexcept {
    return {current().level(0), right_.plane(), left_gradient_.plane(), right_gradient_.plane()};
  }

 private:
  void take_in_left(GrayView image) noexcept;
  void take_in_right(GrayView image) noexcept;

  ImagePyramid pyramids_[2];  ///< Left, of this and the previous frame in turn.
  int newest_ = 0;
  PaddedImage right_;
  PaddedImage left_gradient_;
  PaddedImage right_gradient_;
  std::span<std::uint16_t> scratch_;
};

}  // namespace kinetrace::features
