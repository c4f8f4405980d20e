#include "kinetrace/segmentation/cell_disparity.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>

#include "dense_kernels.hpp"

namespace kinetrace::segmentation {
namespace {

constexpr int kMaxLevels = 80;
constexpr int kPairs = kMatchHeight / kMatchedRows;
/// Least cost of any other level, relative to the best: a ratio, and a noise of one grey level in each pixel.
constexpr int kSecondPercent = 115;
constexpr int kNoiseCost = kMatchWidth * kMatchHeight;

}  // namespace

CellDisparity::CellDisparity(const StereoGeometry& geometry, Arena& arena) : step_(matching_step(geometry.width_px)) {
  const int width = (geometry.width_px + step_ - 1) / step_;
  const int height = (geometry.height_px + step_ - 1) / step_;
  // A row more than the image, since vectors read beyond the end of the last one.
  left_gradient_ = take_image<std::uint8_t>(arena, width, height + 1);
  right_gradient_ = take_image<std::uint8_t>(arena, width, height + 1);
  disparity_ = take_image<float>(arena, (geometry.width_px + kCellPx - 1) / kCellPx,
                                 (geometry.height_px + kCellPx - 1) / kCellPx);
  const auto cells = static_cast<std::size_t>(disparity_.stride);
  scratch_ = arena.take<std::int16_t>(static_cast<std::size_t>(left_gradient_.width / 2) + kMatchSpill);
  for (std::span<std::int16_t>& costs : pair_costs_) {
    costs = arena.take<std::int16_t>(cells * kMaxLevels + kMatchSpill);
  }
  costs_ = arena.take<std::int16_t>(cells * kMaxLevels);
  best_ = arena.take<std::int16_t>(cells);
  cost_ = arena.take<std::int16_t>(cells);
  second_cost_ = arena.take<std::int16_t>(cells);
  right_cost_ = arena.take<std::int16_t>(static_cast<std::size_t>(width));
  right_level_ = arena.take<std::int16_t>(static_cast<std::size_t>(width));
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
  pairs_ = 0;
  for (int cy = 0; cy < disparity_.height; ++cy) {
    match_cells(left, cy, levels);
  }
}

// Windows of neighbouring rows of cells overlap, so each pair of rows is matched only once.
void CellDisparity::match_cells(GrayView left, int cy, int levels) {
  const int pitch = kCellPx / step_;
  const int top_row = (pitch - kMatchHeight) / 2;  // of the first row of cells, above the image
  const int first_row = cy * pitch + top_row;
  if (first_row < 0 || first_row + kMatchHeight > left.height) {
    return;
  }
  const int cells = disparity_.width;
  const int stride = disparity_.stride;
  const DenseKernels& kernels = dense_kernels();
  const int offset = (pitch - kMatchWidth) / 2;
  const int first_pair = cy * pitch / kMatchedRows;
  std::array<const std::int16_t*, kPairs> pair_costs{};
  for (int k = 0; k < kPairs; ++k) {
    const int pair = first_pair + k;
    std::int16_t* const costs = pair_costs_[static_cast<std::size_t>(pair % kPairs)].data();
    if (pair >= pairs_) {
      kernels.match_row_pair(left_gradient_, right_gradient_, top_row + kMatchedRows * pair, pitch, offset, cells,
                             levels, scratch_.data(), costs, stride);
      pairs_ = pair + 1;
    }
    pair_costs[static_cast<std::size_t>(k)] = costs;
  }
  kernels.choose_levels(pair_costs.data(), cells, levels, stride, costs_.data(), best_.data(), cost_.data(),
                        second_cost_.data());
  match_from_right(pitch, cells);
  float* const out = disparity_.row(cy);
  for (int i = 0; i < cells; ++i) {
    const auto k = static_cast<std::size_t>(i);
    const int best = best_[k];
    const int cost = cost_[k];
    if (cost == kNoCost || second_cost_[k] == kNoCost || best + 1 >= levels ||
        100 * second_cost_[k] < kSecondPercent * cost + 100 * kNoiseCost || is_taken(i * pitch, best)) {
      continue;
    }
    const auto at = [&](int d) {
      return static_cast<float>(costs_[static_cast<std::size_t>(d) * static_cast<std::size_t>(stride) + k]);
    };
    float level = static_cast<float>(best);
    if (best > 0 && at(best - 1) < static_cast<float>(kNoCost) && at(best + 1) < static_cast<float>(kNoCost)) {
      // Two straight lines of the same slope: the shape of a sum of absolute differences around its minimum.
      const float slope = std::max(at(best - 1), at(best + 1)) - static_cast<float>(cost);
      level += slope > 0.F ? 0.5F * (at(best - 1) - at(best + 1)) / slope : 0.F;
    }
    out[i] = level * static_cast<float>(step_);
  }
}

// A pixel of the right image shows one surface: of the cells that match it, the one of least cost.
void CellDisparity::match_from_right(int pitch, int cells) noexcept {
  std::fill(right_cost_.begin(), right_cost_.end(), kNoCost);
  for (int i = 0; i < cells; ++i) {
    const auto k = static_cast<std::size_t>(i);
    const int x = i * pitch - best_[k];
    for (int at = std::max(x, 0); at < std::min(x + pitch, static_cast<int>(right_cost_.size())); ++at) {
      const auto r = static_cast<std::size_t>(at);
      if (cost_[k] < right_cost_[r]) {
        right_cost_[r] = cost_[k];
        right_level_[r] = best_[k];
      }
    }
  }
}

bool CellDisparity::is_taken(int x, int level) const noexcept {
  const int at = x - level;
  return at < 0 || std::abs(right_level_[static_cast<std::size_t>(at)] - level) > 1;
}

}  // namespace kinetrace::segmentation
