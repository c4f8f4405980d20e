// The part of RegionMask that completes the outlines of vehicles.
#include <algorithm>
#include <cmath>

#include "kinetrace/segmentation/person_size.hpp"
#include "kinetrace/segmentation/region_mask.hpp"
#include "row_hull.hpp"

namespace kinetrace::segmentation {
namespace {

/// Log-likelihood ratio of an object above the ground below which a cell is ground.
constexpr float kGroundCellNats = -1.F;

}  // namespace

void RegionMask::complete_vehicles(std::span<const Feature> features, const DenseView& dense) noexcept {
  // A feature that no candidate has shows what its cell shows.
  for (const Feature& feature : features) {
    const int x = static_cast<int>(feature.left_px.x()) / kCellPx;
    const int y = static_cast<int>(feature.left_px.y()) / kCellPx;
    if (owner_.contains(x, y) && owner_.row(y)[x] == kFree) {
      owner_.row(y)[x] = kClosed;
    }
  }
  for (std::size_t c = 0; c < candidates_.size(); ++c) {
    complete_vehicle(static_cast<std::int16_t>(c), dense);
  }
}

PixelBox RegionMask::find_rows(std::int16_t index) noexcept {
  PixelBox cells;
  std::fill(first_column_.begin(), first_column_.end(), kNoColumn);
  std::fill(last_column_.begin(), last_column_.end(), kNoColumn);
  for (int y = 0; y < owner_.height; ++y) {
    const auto row = static_cast<std::size_t>(y);
    for (int x = 0; x < owner_.width; ++x) {
      if (owner_.row(y)[x] == index) {
        cells.include(x, y);
        first_column_[row] = std::min(first_column_[row], static_cast<float>(x));
        last_column_[row] = std::min(last_column_[row], -static_cast<float>(x));  // as make_convex has it
      }
    }
  }
  return cells;
}

// By its plain parts: cells without a disparity, or with one of its depth.
void RegionMask::complete_vehicle(std::int16_t index, const DenseView& dense) noexcept {
  const Candidate& candidate = candidates_[static_cast<std::size_t>(index)];
  const PixelBox cells = find_rows(index);
  if (!is_larger_than_people(cells, candidate.disparity_px, kCellPx * static_cast<float>(geometry_.baseline_m))) {
    return;
  }
  make_convex(first_column_);
  make_convex(last_column_);
  for (int y = cells.y0; y < cells.y1; ++y) {
    const auto row = static_cast<std::size_t>(y);
    const int x1 = static_cast<int>(std::floor(-last_column_[row]));
    for (int x = static_cast<int>(std::ceil(first_column_[row])); x <= x1; ++x) {
      const float d = dense.disparity.disparity_px().row(y)[x];
      const bool is_other = d >= 0.F && (d > candidate.near_px || d < candidate.far_px ||
                                         dense.ground.object_nats(cell_center(x), cell_center(y), d,
                                                                  dense.disparity.sigma_px()) < kGroundCellNats);
      if (owner_.row(y)[x] == kFree && !is_other) {
        owner_.row(y)[x] = static_cast<std::int16_t>(index + kCompleted);
      }
    }
  }
}

}  // namespace kinetrace::segmentation
