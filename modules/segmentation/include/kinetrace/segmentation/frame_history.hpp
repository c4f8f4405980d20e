// The last few left images, at matching size, and their camera poses.
#pragma once

#include <array>
#include <cstdint>

#include "kinetrace/core/arena.hpp"
#include "kinetrace/core/image_view.hpp"
#include "kinetrace/core/se3.hpp"

namespace kinetrace::segmentation {

/// One of them; an empty image means none.
struct PastFrame {
  GrayView image;
  Se3 T_world_cam;
  std::int64_t timestamp_ns = 0;
};

class FrameHistory {
 public:
  static constexpr int kFrames = 4;

  FrameHistory() = default;
  FrameHistory(int width, int height, Arena& arena);

  void clear() noexcept { count_ = 0; }
  /// `left`: full size, or empty.
  void push(GrayView left, const Se3& T_world_cam, std::int64_t timestamp_ns);
  [[nodiscard]] int size() const noexcept { return count_; }
  /// `lag` 0: the newest one. lag < size().
  [[nodiscard]] const PastFrame& at(int lag) const noexcept {
    return frames_[static_cast<std::size_t>((next_ + kFrames - 1 - lag) % kFrames)];
  }

 private:
  std::array<MutableGrayView, kFrames> images_;
  std::array<PastFrame, kFrames> frames_;
  int next_ = 0;
  int count_ = 0;
};

}  // namespace kinetrace::segmentation
