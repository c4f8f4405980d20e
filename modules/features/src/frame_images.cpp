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
  nodes_ = arena.take<WarpNode>(static_cast<std::size_t>(width_px / kWarpBlock) + 2);
  scratch_ = arena.take<std::uint16_t>(static_cast<std::size_t>(width_px) + kSpill);
}

void FrameImages::take_in(const RectifiedPair& pair, const RigCorrection& correction, Workers* workers) noexcept {
  newest_ = 1 - newest_;
  in_pieces(workers, 2, 1, [&](std::size_t begin, std::size_t end) {
    for (std::size_t view = begin; view < end; ++view) {
      view == 0 ? take_in_left(pair.left) : take_in_right(pair, correction);
    }
  });
}

void FrameImages::take_in_left(GrayView image) noexcept {
  pyramids_[newest_].build(image, scratch_);
  take_gradient(current().level(0), left_gradient_);
}

void FrameImages::take_in_right(const RectifiedPair& pair, const RigCorrection& correction) noexcept {
  if (correction.turn_rad.isZero(0.0) && correction.shift_rad == 0.0) {
    copy_image(pair.right, right_.pixels());
  } else {
    turn_right(pair, correction);
  }
  right_.pad();
  take_gradient(right_.plane(), right_gradient_);
}

void FrameImages::turn_right(const RectifiedPair& pair, const RigCorrection& correction) noexcept {
  const Eigen::Matrix3d raw_from_turned = correction.raw_from_turned(pair.geometry);
  const Plane source{pair.right.data, pair.right.width, pair.right.height, pair.right.stride, 0};
  const MutableGrayView target = right_.pixels();
  for (int y = 0; y < target.height; ++y) {
    for (std::size_t i = 0; i < nodes_.size(); ++i) {
      const Eigen::Vector2d at =
          (raw_from_turned * Eigen::Vector3d(kWarpBlock * static_cast<double>(i), y, 1.0)).hnormalized();
      nodes_[i] = {static_cast<float>(at.x()), static_cast<float>(at.y())};
    }
    kernels().warp.warp_row(source, nodes_.data(), target.width, target.row(y));
  }
}

}  // namespace kinetrace::features
