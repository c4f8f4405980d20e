// A coarse dense disparity map: one value for each cell of 4x4 pixels.
#pragma once

#include <array>
#include <cstdint>
#include <span>

#include "kinetrace/core/arena.hpp"
#include "kinetrace/core/image_view.hpp"
#include "kinetrace/core/stereo_geometry.hpp"

namespace kinetrace::segmentation {

/// Pixels of a cell's side.
inline constexpr int kCellPx = 4;
/// Pixel coordinate of the middle of cell `c`.
[[nodiscard]] constexpr float cell_center(int c) noexcept {
  return static_cast<float>(c * kCellPx) + 0.5F * static_cast<float>(kCellPx - 1);
}
/// Wider images are matched at half their size.
inline constexpr int kMaxMatchingWidthPx = 800;

/// Block matching of horizontal gradients, which are insensitive to the cameras' difference in gain: the level of least
/// cost, refined by a parabola, if no other level comes close. Textureless cells have no disparity.
class CellDisparity {
 public:
  CellDisparity() = default;
  CellDisparity(const StereoGeometry& geometry, Arena& arena);

  /// `left`, `right`: matching images, see matching_step(). Searches levels up to `max_disparity_px` (of the full
  /// image), within the memory's capacity.
  void compute(GrayView left, GrayView right, float max_disparity_px);
  void clear() noexcept;

  /// Standard deviation of known disparities, pixels of the full image.
  [[nodiscard]] float sigma_px() const noexcept { return 0.2F * static_cast<float>(step_); }
  /// Pixels of the full image; negative where unknown.
  [[nodiscard]] ImageView<const float> disparity_px() const noexcept { return disparity_; }

 private:
  void match_cells(GrayView left, int cy, int levels);
  void match_from_right(int pitch, int cells) noexcept;
  [[nodiscard]] bool is_taken(int x, int level) const noexcept;

  int step_ = 1;
  MutableGrayView left_gradient_;
  MutableGrayView right_gradient_;
  ImageView<float> disparity_;
  std::span<std::int16_t> scratch_;
  std::array<std::span<std::int16_t>, 3> pair_costs_;  ///< Of the last pairs of rows, a ring...
  int pairs_ = 0;                                      ///< ...and their number.
  std::span<std::int16_t> costs_;
  std::span<std::int16_t> best_;
  std::span<std::int16_t> cost_;
  std::span<std::int16_t> second_cost_;
  // By pixel of a right row: the least cost of the cells that match it, and their level.
  std::span<std::int16_t> right_cost_;
  std::span<std::int16_t> right_level_;
};

/// Reduction of the matching images against the full ones: 1 or 2.
[[nodiscard]] constexpr int matching_step(int width_px) noexcept {
  return width_px > kMaxMatchingWidthPx ? 2 : 1;
}

}  // namespace kinetrace::segmentation
