#include "frame_images.hpp"

#include "kernels.hpp"

namespace kinetrace::features {
namespace {

void take_gradient(const Plane& image, PaddedImage& gradient) noexcept {
  const MutableGrayView pixels = gradient.pixels();
  kernels().pyramid.horizontal_gradient(image, pixels.data, pixels.stride);
  gradient.pad();
}

}  // namespace

FrameImages::FrameImages(Arena& arena, int width_px, int height_px, int pyramid_levels) {
  for (ImagePyramid& pyramid : pyramids_) {
    pyramid = ImagePyramid(arena, width_px, height_px, pyramid_levels);
  }
  right_ = PaddedImage(arena, width_px, height_px);
  left_gradient_ = PaddedImage(arena, width_px, height_px);
  right_gradient_ = PaddedImage(arena, width_px, height_px);
  constexpr std::size_t kSpill = 32;
  scratch_ = arena.take<std::uint16_t>(static_cast<std::size_t>(width_px) + kSpill);
}

void FrameImages::take_in(const RectifiedPair& pair, Workers* workers) noexcept {
  newest_ = 1 - newest_;
  in_pieces(workers, 2, 1, [&](std::size_t begin, std::size_t end) {
    for (std::size_t view = begin; view < end; ++view) {
      view == 0 ? take_in_left(pair.left) : take_in_right(pair.right);
    }
  });
}

void FrameImages::take_in_left(GrayView image) noexcept {
  pyramids_[newest_].build(image, scratch_);
  take_gradient(current().level(0), left_gradient_);
}

void FrameImages::take_in_right(GrayView image) noexcept {
  copy_image(image, right_.pixels());
  right_.pad();
  take_gradient(right_.plane(), right_gradient_);
}

}  // namespace kinetrace::features
