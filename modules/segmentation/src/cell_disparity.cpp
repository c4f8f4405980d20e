#include "kinetrace/segmentation/cell_disparity.hpp"

#include <algorithm>
#include <cmath>

#include "dense_kernels.hpp"

namespace kinetrace::segmentation {
namespace {

constexpr int kMaxLevels = 80;
/// Cost over the best that any other level must have: a ratio, and a noise of one grey level in each pixel.
constexpr int kRivalPercent = 115;
constexpr int kNoiseCost = kMatchWidth * kMatchHeight;

}  // namespace

CellDisparity::CellDisparity(const StereoGeometry& geometry, Arena& arena) : step_(matching_step(geometry.width_px)) {
  const int width = (geometry.width_px + step_ - 1) / step_;
  const int height = (geometry.height_px + step_ - 1) / step_;
  // A row more than the image: the last one is read beyond its end, too.
  left_gradient_ = take_image<std::uint8_t>(arena, width, height + 1);
  right_gradient_ = take_image<std::uint8_t>(arena, width, height + 1);
  disparity_ = take_image<float>(arena, (geometry.width_px + kCellPx - 1) / kCellPx,
                                 (geometry.height_px + kCellPx - 1) / kCellPx);
  const auto cells = static_cast<std::size_t>(disparity_.stride);
  columns_ = arena.take<std::int16_t>(static_cast<std::size_t>(left_gradient_.width + kMatchSpill));
  costs_ = arena.take<std::int16_t>(cells * kMaxLevels);
  best_ = arena.take<std::int16_t>(cells);
  cost_ = arena.take<std::int16_t>(cells);
  rival_ = arena.take<std::int16_t>(cells);
}

void CellDisparity::clear() noexcept {
  for (int y = 0; y < disparity_.height; ++y) {
    std::fill_n(disparity_.row(y), disparity_.width, -1.F);
  }
}

void CellDisparity::compute(GrayView left, GrayView right, float max_disparity_px) {
  clear();
  const DenseKernels& kernels = dense_kernels();
  kernels.horizontal_gradient(left, left_gradient_);
  kernels.horizontal_gradient(right, right_gradient_);
  const int levels = std::clamp(static_cast<int>(std::ceil(max_disparity_px)) / step_ + 2, 4, kMaxLevels);
  for (int cy = 0; cy < disparity_.height; ++cy) {
    match_cells(left, cy, levels);
  }
}

void CellDisparity::match_cells(GrayView left, int cy, int levels) {
  const int pitch = kCellPx / step_;
  const int first_row = cy * pitch + (pitch - kMatchHeight) / 2;
  if (first_row < 0 || first_row + kMatchHeight > left.height) {
    return;
  }
  const int cells = disparity_.width;
  const int stride = disparity_.stride;
  const DenseKernels& kernels = dense_kernels();
  const int offset = (pitch - kMatchWidth) / 2;
  // Cells whose window sticks out of the image to the left have no cost at any level.
  kernels.match_row(left_gradient_, right_gradient_, first_row, pitch, offset, cells, levels, columns_.data(),
                    costs_.data(), stride);
  kernels.choose_levels(costs_.data(), cells, levels, stride, best_.data(), cost_.data(), rival_.data());
  float* const out = disparity_.row(cy);
  for (int i = 0; i < cells; ++i) {
    const auto k = static_cast<std::size_t>(i);
    const int best = best_[k];
    const int cost = cost_[k];
    if (cost == kNoCost || rival_[k] == kNoCost || best + 1 >= levels ||
        100 * rival_[k] < kRivalPercent * cost + 100 * kNoiseCost) {
      continue;
    }
    const auto at = [&](int d) { return static_cast<float>(costs_[static_cast<std::size_t>(d * stride + i)]); };
    float level = static_cast<float>(best);
    if (best > 0 && at(best - 1) < static_cast<float>(kNoCost) && at(best + 1) < static_cast<float>(kNoCost)) {
      // Two straight lines of the same slope: what a sum of absolute differences looks like around its minimum.
      const float slope = std::max(at(best - 1), at(best + 1)) - static_cast<float>(cost);
      level += slope > 0.F ? 0.5F * (at(best - 1) - at(best + 1)) / slope : 0.F;
    }
    out[i] = level * static_cast<float>(step_);
  }
}

}  // namespace kinetrace::segmentation
