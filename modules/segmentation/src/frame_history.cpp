#include "kinetrace/segmentation/frame_history.hpp"

#include <algorithm>

#include "dense_kernels.hpp"

namespace kinetrace::segmentation {

FrameHistory::FrameHistory(int width, int height, Arena& arena) {
  for (MutableGrayView& image : images_) {
    image = take_image<std::uint8_t>(arena, width, height + 1);  // vectors reach beyond the last row
    image.height = height;
  }
}

void FrameHistory::push(GrayView left, const Se3& T_world_cam, std::int64_t timestamp_ns) {
  const auto slot = static_cast<std::size_t>(next_);
  PastFrame& frame = frames_[slot];
  frame = {{}, T_world_cam, timestamp_ns};
  if (!left.empty()) {
    dense_kernels().decimate(left, left.width > images_[slot].width ? 2 : 1, images_[slot]);
    frame.image = images_[slot];
  }
  next_ = (next_ + 1) % kFrames;
  count_ = std::min(count_ + 1, kFrames);
}

}  // namespace kinetrace::segmentation
