// The region masks of the frame before.
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <utility>

#include "kinetrace/segmentation/region_mask.hpp"

namespace kinetrace::segmentation {
namespace {

/// Least evidence of the images, over a whole region, to continue it without features.
constexpr float kMovesOnNats = 3.F;
/// Gap, across the line of sight, between a region and a part of it: plain parts have no cells.
constexpr float kGapM = 0.6F;
/// Expected gain of a velocity of its own for a part of a region: half a nat for each of three fitted parameters.
constexpr float kFittedNats = 1.5F;

}  // namespace

void RegionMask::join_cells(std::span<const JoinedRegion> joined) {
  for (const JoinedRegion& region : joined) {
    for (int cy = 0; cy < previous_.height; ++cy) {
      std::replace(previous_.row(cy), previous_.row(cy) + previous_.width, region.part, region.whole);
    }
  }
}

void RegionMask::take_over_cells(std::size_t region, std::span<const Feature> features, const MotionMemory& memory) {
  const MotionRegion& own = memory.regions()[region];
  for (int cy = 0; cy < previous_.height; ++cy) {
    for (int cx = 0; cx < previous_.width; ++cx) {
      std::uint32_t& drawn_as = previous_.row(cy)[cx];
      if (drawn_as != own.beside) {
        continue;
      }
      const Eigen::Vector2f cell_px(cell_center(cx), cell_center(cy));
      float nearest_sq = std::numeric_limits<float>::max();
      for (std::size_t i = 0; i < features.size(); ++i) {
        const std::int16_t r = memory.region_of_feature()[i];
        const std::uint32_t id = r < 0 ? 0U : memory.regions()[static_cast<std::size_t>(r)].id;
        const float distance_sq = (features[i].previous_left_px - cell_px).squaredNorm();
        if (features[i].age_frames > 0 && (id == own.id || id == own.beside) && distance_sq < nearest_sq) {
          nearest_sq = distance_sq;
          drawn_as = id;
        }
      }
    }
  }
}

const RegionMask::Candidate* RegionMask::drawn(std::uint32_t region_id) const noexcept {
  const auto* const found =
      std::find_if(drawn_.begin(), drawn_.end(), [region_id](const Candidate& c) { return c.region_id == region_id; });
  return found == drawn_.end() ? nullptr : found;
}

bool RegionMask::moves_on(const MotionRegion& region, const DenseView& dense, const TemporalTest& test) const {
  const Candidate* const before = drawn(region.id);
  if (before == nullptr || dense.history.size() < 2) {
    return false;
  }
  const Eigen::Vector3f& velocity = region.velocity_mps;
  const PixelBox& box = before->cells;
  const ImageView<const float> disparity = dense.disparity.disparity_px();
  const int lag = test.discriminating_lag(velocity, cell_center((box.x0 + box.x1) / 2),
                                          cell_center((box.y0 + box.y1) / 2), before->disparity_px);
  const TemporalTest::Hypotheses hypotheses = test.hypotheses(velocity, lag);
  const PastPlaces places = test.places(velocity, 1);
  float total = 0.F;
  for (int cy = box.y0; cy < box.y1; ++cy) {
    for (int cx = box.x0; cx < box.x1; ++cx) {
      const Eigen::Vector2f from = places.at(cell_center(cx), cell_center(cy), before->disparity_px) / kCellPx;
      const int px = static_cast<int>(from.x());
      const int py = static_cast<int>(from.y());
      if (from.x() < 0.F || from.y() < 0.F || !previous_.contains(px, py) || previous_.row(py)[px] != region.id) {
        continue;
      }
      const float d = disparity.row(cy)[cx];
      if (d < 0.F || (d >= before->far_px && d <= before->near_px)) {
        total += test.cell_nats(hypotheses, cx, cy, d < 0.F ? before->disparity_px : d);
      }
    }
  }
  return total >= kMovesOnNats * test.overlap();
}

std::span<const std::uint32_t> RegionMask::inherited_regions(std::span<const Feature> features) {
  inherited_.clear();
  for (const Feature& feature : features) {
    const int x = static_cast<int>(std::lround(feature.previous_left_px.x()));
    const int y = static_cast<int>(std::lround(feature.previous_left_px.y()));
    const bool on_tracked_body = feature.body != kBackgroundLabel && feature.body <= kMaxObjects;
    const bool found_last_frame = feature.age_frames == 1 && on_tracked_body && labels_.contains(x, y);
    (void)inherited_.push_back(found_last_frame ? region_of_label_[labels_.at(x, y)] : 0U);  // beyond: not looked at
  }
  return inherited_.span();
}

std::span<const std::uint32_t> RegionMask::drawn_regions(std::span<const Feature> features) {
  drawn_region_.clear();
  for (const Feature& feature : features) {
    const int x = static_cast<int>(std::lround(feature.previous_left_px.x()));
    const int y = static_cast<int>(std::lround(feature.previous_left_px.y()));
    const bool before = feature.age_frames > 0 && labels_.contains(x, y);
    (void)drawn_region_.push_back(before ? region_of_label_[labels_.at(x, y)] : 0U);  // beyond: not looked at
  }
  return drawn_region_.span();
}

std::span<const std::uint32_t> RegionMask::drawn_as(std::span<const MovingBlob> blobs,
                                                    ImageView<const std::int16_t> blob_of_cell, const DenseView& dense,
                                                    const TemporalTest& test) {
  std::array<std::array<std::uint16_t, MotionMemory::kMaxRegions>, MovingBlobs::kMaxBlobs> votes{};
  for (int cy = 0; cy < blob_of_cell.height && dense.history.size() > 1; ++cy) {
    for (int cx = 0; cx < blob_of_cell.width; ++cx) {
      if (blob_of_cell.row(cy)[cx] < 0) {
        continue;
      }
      const auto b = static_cast<std::size_t>(blob_of_cell.row(cy)[cx]);
      const Eigen::Vector2f from =
          test.places(blobs[b].velocity_mps, 1)
              .at(cell_center(cx), cell_center(cy), dense.disparity.disparity_px().row(cy)[cx]) /
          kCellPx;
      const int x = static_cast<int>(from.x());
      const int y = static_cast<int>(from.y());
      for (std::size_t k = 0; k < drawn_.size() && from.x() >= 0.F && from.y() >= 0.F && previous_.contains(x, y);
           ++k) {
        votes[b][k] = static_cast<std::uint16_t>(votes[b][k] + (drawn_[k].region_id == previous_.row(y)[x] ? 1 : 0));
      }
    }
  }
  drawn_as_.clear();
  for (std::size_t b = 0; b < blobs.size(); ++b) {
    const auto most = std::max_element(votes[b].begin(), votes[b].end());
    std::uint32_t region = 0;
    if (2 * *most >= blobs[b].cells) {
      region = drawn_[static_cast<std::size_t>(most - votes[b].begin())].region_id;
    } else if (blobs[b].moving) {
      region = part_of(blobs[b], static_cast<std::int16_t>(b), blob_of_cell, dense, test);
    }
    (void)drawn_as_.push_back(region);
  }
  return drawn_as_.span();
}

std::uint32_t RegionMask::part_of(const MovingBlob& blob, std::int16_t index,
                                  ImageView<const std::int16_t> blob_of_cell, const DenseView& dense,
                                  const TemporalTest& test) const {
  struct Neighbour {
    int cells = 0;
    float nats = 0.F;  // of the blob with the neighbour's velocity
  };
  std::array<Neighbour, MotionMemory::kMaxRegions> neighbours{};
  const int lag = test.lag_after(MovingBlobs::kLookBackS);
  const TemporalTest::Hypotheses own = test.hypotheses(blob.velocity_mps, lag);
  float own_nats = 0.F;
  for (int cy = 0; cy < blob_of_cell.height; ++cy) {
    for (int cx = 0; cx < blob_of_cell.width; ++cx) {
      if (blob_of_cell.row(cy)[cx] != index) {
        continue;
      }
      const float d = dense.disparity.disparity_px().row(cy)[cx];
      const std::uint32_t beside = region_beside(cx, cy, d);
      own_nats += test.cell_nats(own, cx, cy, d);
      for (std::size_t k = 0; k < drawn_.size(); ++k) {
        neighbours[k].cells += drawn_[k].region_id == beside ? 1 : 0;
        neighbours[k].nats += test.cell_nats(test.hypotheses(drawn_[k].velocity_mps, lag), cx, cy, d);
      }
    }
  }
  const auto nearest = std::max_element(neighbours.begin(), neighbours.end(),
                                        [](const Neighbour& a, const Neighbour& b) { return a.cells < b.cells; });
  const bool moves_with_it =
      nearest->cells > 0 && nearest->nats > 0.F && own_nats - nearest->nats < kFittedNats * test.overlap();
  return moves_with_it ? drawn_[static_cast<std::size_t>(nearest - neighbours.begin())].region_id : 0U;
}

std::uint32_t RegionMask::region_beside(int cx, int cy, float disparity_px) const noexcept {
  const int gap = static_cast<int>(kGapM * disparity_px / static_cast<float>(geometry_.baseline_m)) / kCellPx + 1;
  for (int k = 1; k <= gap; ++k) {
    for (const auto& [x, y] : {std::pair{cx - k, cy}, {cx + k, cy}, {cx, cy - k}, {cx, cy + k}}) {
      if (previous_.contains(x, y) && previous_.row(y)[x] != 0) {
        return previous_.row(y)[x];
      }
    }
  }
  return 0;
}

}  // namespace kinetrace::segmentation
