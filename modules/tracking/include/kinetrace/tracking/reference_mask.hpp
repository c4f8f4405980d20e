// The last observed mask of one object, to be drawn at its predicted position.
#pragma once

#include <cstdint>
#include <span>
#include <utility>

#include <Eigen/Core>

#include "kinetrace/core/arena.hpp"
#include "kinetrace/core/image_view.hpp"
#include "kinetrace/tracking/similarity.hpp"

namespace kinetrace::tracking {

/// One bit per image pixel, with the similarity that maps it to the current frame. A propagated mask is drawn from the
/// last observed one by the product of all motions since, never from a drawn one: resampling losses do not accumulate,
/// and parts occluded by a nearer object reappear on its other side.
class ReferenceMask {
 public:
  ReferenceMask() = default;
  ReferenceMask(Arena& arena, int width, int height);

  /// Takes the pixels of `labels` in `box` for which `belongs(label, x, y)` holds.
  template <typename Belongs>
  void capture(LabelView labels, const PixelBox& box, Belongs&& belongs) noexcept {
    now_from_ref_ = {};
    box_ = {};
    for (int y = box.y0; y < box.y1; ++y) {
      const std::uint8_t* source = labels.row(y);
      std::uint8_t* target = row(y);
      std::fill(target + box.x0 / 8, target + (box.x1 + 7) / 8, std::uint8_t{0});
      int first = box.x1;
      int last = -1;
      for (int x = box.x0; x < box.x1; ++x) {
        if (belongs(source[x], x, y)) {
          target[x >> 3] = static_cast<std::uint8_t>(target[x >> 3] | (1U << (static_cast<unsigned>(x) & 7U)));
          first = std::min(first, x);
          last = x;
        }
      }
      if (last >= 0) {
        box_.include(first, y);
        box_.include(last, y);
      }
    }
  }

  /// Places the captured mask by `now_from_reference`. Returns the motion from its previous place.
  Similarity place(const Similarity& now_from_reference) noexcept {
    const Similarity before_from_ref = std::exchange(now_from_ref_, now_from_reference);
    return now_from_ref_ * before_from_ref.inverse();
  }
  /// Part of the mask's box that lies in the image now.
  [[nodiscard]] double part_in_image() const noexcept;

  /// The object has moved by `motion` (image of the previous frame to image of the current one).
  void move(const Similarity& motion) noexcept { now_from_ref_ = motion * now_from_ref_; }

  /// Where the mask lies now, clipped to the image.
  [[nodiscard]] PixelBox current_box() const noexcept;
  /// Where the mask's box lies now, not clipped, as its lowest and highest corner.
  void current_corners(Eigen::Vector2d& low, Eigen::Vector2d& high) const noexcept;
  /// Half the diagonal of the mask now, not clipped.
  [[nodiscard]] double current_reach_px() const noexcept;
  /// Centre of the mask's box now, not clipped.
  [[nodiscard]] Eigen::Vector2d current_center() const noexcept;

  /// Calls visit(x, y) for each pixel of the current frame that the mask covers, row by row; inverse mapping, nearest
  /// pixel.
  template <typename Visit>
  void for_each_pixel(const PixelBox& region, Visit&& visit) const noexcept {
    const Similarity ref_from_now = now_from_ref_.inverse();
    const auto step_x = to_fixed(ref_from_now.a);
    const auto step_y = to_fixed(ref_from_now.b);
    for (int y = region.y0; y < region.y1; ++y) {
      const Eigen::Vector2d start = ref_from_now * Eigen::Vector2d(region.x0, y);
      std::int64_t fx = to_fixed(start.x()) + kHalf;
      std::int64_t fy = to_fixed(start.y()) + kHalf;
      for (int x = region.x0; x < region.x1; ++x, fx += step_x, fy += step_y) {
        if (covers(static_cast<int>(fx >> kFractionBits), static_cast<int>(fy >> kFractionBits))) {
          visit(x, y);
        }
      }
    }
  }

 private:
  static constexpr int kFractionBits = 20;
  static constexpr std::int64_t kHalf = std::int64_t{1} << (kFractionBits - 1);
  [[nodiscard]] static std::int64_t to_fixed(double value) noexcept {
    return static_cast<std::int64_t>(value * static_cast<double>(std::int64_t{1} << kFractionBits));
  }
  [[nodiscard]] std::uint8_t* row(int y) const noexcept {
    return bits_.data() + static_cast<std::ptrdiff_t>(y) * row_bytes_;
  }
  [[nodiscard]] bool covers(int x, int y) const noexcept {
    // Unsigned differences test both ends of an interval at once.
    return static_cast<unsigned>(x - box_.x0) < static_cast<unsigned>(box_.width()) &&
           static_cast<unsigned>(y - box_.y0) < static_cast<unsigned>(box_.height()) &&
           ((row(y)[x >> 3] >> (static_cast<unsigned>(x) & 7U)) & 1U) != 0;
  }

  std::span<std::uint8_t> bits_;
  int width_ = 0;
  int height_ = 0;
  int row_bytes_ = 0;
  PixelBox box_;  ///< Bits outside are meaningless.
  Similarity now_from_ref_;
};

}  // namespace kinetrace::tracking
