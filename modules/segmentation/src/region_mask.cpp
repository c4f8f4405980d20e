#include "kinetrace/segmentation/region_mask.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "velocity_test.hpp"

namespace kinetrace::segmentation {
namespace {

/// How far an object reaches beyond its outermost features.
constexpr float kMarginM = 0.25F;
/// The same where few features mark it.
constexpr float kSparseMarginM = 0.4F;
constexpr int kFewMembers = 8;
/// The margin around a feature is an octagon.
constexpr std::size_t kRimDirections = 8;
constexpr float kMinMarginPx = 5.F;
constexpr float kMaxMarginPx = 24.F;
/// (m/s)^2 by which velocities on one object may differ.
constexpr float kVelocityVariance = 0.1F;
/// Relative difference of disparity that tells a resting object from its surroundings.
constexpr float kDistinctDisparityRatio = 0.15F;

float cross(const Eigen::Vector2f& a, const Eigen::Vector2f& b, const Eigen::Vector2f& c) noexcept {
  return (b.x() - a.x()) * (c.y() - a.y()) - (b.y() - a.y()) * (c.x() - a.x());
}

float hull_area(std::span<const Eigen::Vector2f> hull) noexcept {
  float twice = 0.F;
  for (std::size_t i = 0; i < hull.size(); ++i) {
    const Eigen::Vector2f& a = hull[i];
    const Eigen::Vector2f& b = hull[(i + 1) % hull.size()];
    twice += a.x() * b.y() - b.x() * a.y();
  }
  return 0.5F * std::abs(twice);
}

/// The part of a row y that a convex polygon covers; first > last when none.
struct Interval {
  float first = std::numeric_limits<float>::max();
  float last = std::numeric_limits<float>::lowest();
};

Interval row_of(std::span<const Eigen::Vector2f> hull, float y) noexcept {
  Interval row;
  for (std::size_t i = 0; i < hull.size(); ++i) {
    const Eigen::Vector2f& a = hull[i];
    const Eigen::Vector2f& b = hull[(i + 1) % hull.size()];
    if (y < std::min(a.y(), b.y()) || y > std::max(a.y(), b.y())) {
      continue;
    }
    const float s = a.y() == b.y() ? 0.F : (y - a.y()) / (b.y() - a.y());
    const float x = a.x() + s * (b.x() - a.x());
    row.first = std::min(row.first, x);
    row.last = std::max(row.last, x);
  }
  return row;
}

}  // namespace

RegionMask::RegionMask(const StereoGeometry& geometry, int max_features, int max_objects, int min_area_px, Arena& arena)
    : geometry_(geometry),
      min_area_px_(min_area_px),
      grid_width_((geometry.width_px + kCellPx - 1) / kCellPx),
      grid_height_((geometry.height_px + kCellPx - 1) / kCellPx) {
  const auto n = static_cast<std::size_t>(max_features);
  labels_ = take_image<std::uint8_t>(arena, geometry.width_px, geometry.height_px);
  detections_ = FixedVector<Detection>(arena, static_cast<std::size_t>(max_objects));
  outlines_ = FixedVector<Outline>(arena, MotionMemory::kMaxRegions);
  inherited_ = FixedVector<std::uint32_t>(arena, n);
  members_ = FixedVector<Eigen::Vector2f>(arena, n);
  rim_ = FixedVector<Eigen::Vector2f>(arena, kRimDirections * n);
  others_ = FixedVector<Eigen::Vector2f>(arena, n);
  hull_ = FixedVector<Eigen::Vector2f>(arena, 2 * kRimDirections * n + 2);
  nearest_seed_ =
      arena.take<std::int16_t>(static_cast<std::size_t>(grid_width_) * static_cast<std::size_t>(grid_height_));
  scratch_ = arena.take<float>(n);
}

int RegionMask::draw(std::span<const Feature> features, std::span<const FeatureMotion> motions, MotionMemory& memory) {
  for (int y = 0; y < labels_.height; ++y) {
    std::fill_n(labels_.row(y), labels_.width, kBackgroundLabel);
  }
  const std::span<const Feature> known = features.first(motions.size());
  trace_outlines(known, memory);
  const std::size_t found = outlines_.size();
  outlines_.resize(std::min(found, detections_.capacity()));
  region_of_label_.fill(0);
  for (std::size_t k = 0; k < outlines_.size(); ++k) {
    outlines_[k].label = static_cast<std::uint8_t>(k + 1);
    region_of_label_[k + 1] = memory.regions()[static_cast<std::size_t>(outlines_[k].region)].id;
  }
  detections_.clear();
  detections_.resize(outlines_.size());
  std::sort(outlines_.begin(), outlines_.end(), [](const Outline& a, const Outline& b) {
    return a.disparity_px != b.disparity_px ? a.disparity_px < b.disparity_px : a.label < b.label;
  });
  for (const Outline& outline : outlines_) {
    take_members(outline, known, memory);
    take_others(outline, known, motions, memory);
    build_hull();
    fill(outline);
  }
  measure();
  return static_cast<int>(found - detections_.size());
}

// Size and depth of every reported region, largest first.
void RegionMask::trace_outlines(std::span<const Feature> features, MotionMemory& memory) {
  outlines_.clear();
  for (std::size_t r = 0; r < memory.regions().size(); ++r) {
    if (!memory.regions()[r].reported) {
      continue;
    }
    Outline outline;
    outline.region = static_cast<std::int16_t>(r);
    outline.members = memory.regions()[r].features;
    std::size_t n = 0;
    for (std::size_t i = 0; i < features.size(); ++i) {
      if (memory.region_of_feature()[i] == outline.region && features[i].has_right()) {
        scratch_[n++] = features[i].disparity_px();
      }
    }
    if (n == 0) {
      continue;
    }
    const auto middle = scratch_.begin() + static_cast<std::ptrdiff_t>(n / 2);
    std::nth_element(scratch_.begin(), middle, scratch_.begin() + static_cast<std::ptrdiff_t>(n));
    outline.disparity_px = *middle;
    take_members(outline, features, memory);
    build_hull();
    outline.area_px = hull_area(hull_.span());
    if (memory.accepts_outline(r, outline.area_px)) {
      (void)outlines_.push_back(outline);  // as many places as regions
    }
  }
  std::sort(outlines_.begin(), outlines_.end(), [](const Outline& a, const Outline& b) {
    return a.area_px != b.area_px ? a.area_px > b.area_px : a.region < b.region;
  });
}

void RegionMask::take_members(const Outline& outline, std::span<const Feature> features, const MotionMemory& memory) {
  members_.clear();
  rim_.clear();
  const float margin = margin_px(outline);
  for (std::size_t i = 0; i < features.size(); ++i) {
    if (memory.region_of_feature()[i] != outline.region) {
      continue;
    }
    (void)members_.push_back(features[i].left_px);  // as many places as features; the same for the rim
    if (!memory.proved(i)) {
      (void)rim_.push_back(features[i].left_px);
      continue;
    }
    for (std::size_t k = 0; k < kRimDirections; ++k) {
      constexpr float kDiagonal = 0.70710678F;
      constexpr std::array<std::array<float, 2>, kRimDirections> kDirections{{{1.F, 0.F},
                                                                              {kDiagonal, kDiagonal},
                                                                              {0.F, 1.F},
                                                                              {-kDiagonal, kDiagonal},
                                                                              {-1.F, 0.F},
                                                                              {-kDiagonal, -kDiagonal},
                                                                              {0.F, -1.F},
                                                                              {kDiagonal, -kDiagonal}}};
      (void)rim_.push_back(features[i].left_px + margin * Eigen::Vector2f(kDirections[k][0], kDirections[k][1]));
    }
  }
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

void RegionMask::take_others(const Outline& outline, std::span<const Feature> features,
                             std::span<const FeatureMotion> motions, const MotionMemory& memory) {
  const MotionRegion& region = memory.regions()[static_cast<std::size_t>(outline.region)];
  others_.clear();
  for (std::size_t i = 0; i < features.size(); ++i) {
    if (memory.region_of_feature()[i] == outline.region || !motions[i].known) {
      continue;
    }
    bool distinct = false;
    if (region.moving) {
      const Eigen::Matrix3f covariance =
          motions[i].covariance + region.covariance + kVelocityVariance * Eigen::Matrix3f::Identity();
      distinct = mahalanobis_sq(motions[i].velocity_mps - region.velocity_mps, covariance) > kSameVelocityChi2;
    } else {
      distinct = std::abs(features[i].disparity_px() - outline.disparity_px) >
                 std::max(2.F, kDistinctDisparityRatio * outline.disparity_px);
    }
    if (distinct) {
      (void)others_.push_back(features[i].left_px);  // as many places as features
    }
  }
}

// Convex hull (Andrew's monotone chain), counter-clockwise in a right-handed sense of (x, y).
void RegionMask::build_hull() {
  std::sort(rim_.begin(), rim_.end(), [](const Eigen::Vector2f& a, const Eigen::Vector2f& b) {
    return a.x() != b.x() ? a.x() < b.x() : a.y() < b.y();
  });
  hull_.clear();
  const auto extend = [&](const Eigen::Vector2f& p, std::size_t floor) {
    while (hull_.size() >= floor + 2 && cross(hull_[hull_.size() - 2], hull_.back(), p) <= 0.F) {
      hull_.pop_back();
    }
    (void)hull_.push_back(p);  // at most two entries a point
  };
  for (const Eigen::Vector2f& p : rim_) {
    extend(p, 0);
  }
  const std::size_t lower = hull_.empty() ? 0 : hull_.size() - 1;
  for (std::size_t i = rim_.size(); i-- > 0;) {
    extend(rim_[i], lower);
  }
  if (hull_.size() > 1) {
    hull_.pop_back();  // the first point again
  }
}

float RegionMask::margin_px(const Outline& outline) const noexcept {
  const float margin_m = outline.members < kFewMembers ? kSparseMarginM : kMarginM;
  return std::clamp(margin_m / static_cast<float>(geometry_.baseline_m) * outline.disparity_px, kMinMarginPx,
                    kMaxMarginPx);
}

void RegionMask::fill(const Outline& outline) {
  PixelBox cells;
  for (const Eigen::Vector2f& p : hull_) {
    cells.include(std::clamp(static_cast<int>(p.x()) / kCellPx, 0, grid_width_ - 1),
                  std::clamp(static_cast<int>(p.y()) / kCellPx, 0, grid_height_ - 1));
  }
  find_nearest_seeds(cells);
  const auto member_count = static_cast<std::int16_t>(members_.size());
  for (int cy = cells.y0; cy < cells.y1; ++cy) {
    const Interval inside = row_of(hull_.span(), cell_center(0, cy).y());
    for (int cx = cells.x0; cx < cells.x1; ++cx) {
      const float x = cell_center(cx, cy).x();
      if (x < inside.first || x > inside.last || nearest_seed(cx, cy) >= member_count) {
        continue;
      }
      const int x0 = cx * kCellPx;
      for (int y = cy * kCellPx; y < std::min((cy + 1) * kCellPx, labels_.height); ++y) {
        std::fill(labels_.row(y) + x0, labels_.row(y) + std::min(x0 + kCellPx, labels_.width), outline.label);
      }
    }
  }
}

// Nearest feature of each cell, members first, then others: distance propagation in two sweeps (Danielsson 1980), with
// the features' exact places.
void RegionMask::find_nearest_seeds(const PixelBox& cells) {
  for (int cy = cells.y0; cy < cells.y1; ++cy) {
    std::fill(&nearest_seed(cells.x0, cy), &nearest_seed(cells.x1 - 1, cy) + 1, kNoSeed);
  }
  const auto seed_at = [&](std::int16_t seed) -> const Eigen::Vector2f& {
    const auto i = static_cast<std::size_t>(seed);
    return i < members_.size() ? members_[i] : others_[i - members_.size()];
  };
  const auto offer = [&](int cx, int cy, std::int16_t seed) {
    std::int16_t& held = nearest_seed(cx, cy);
    if (seed == kNoSeed || seed == held) {
      return;
    }
    const Eigen::Vector2f center = cell_center(cx, cy);
    if (held == kNoSeed || (seed_at(seed) - center).squaredNorm() < (seed_at(held) - center).squaredNorm()) {
      held = seed;
    }
  };
  const auto seeds = static_cast<std::int16_t>(members_.size() + others_.size());
  for (std::int16_t seed = 0; seed < seeds; ++seed) {
    const int cx = static_cast<int>(seed_at(seed).x()) / kCellPx;
    const int cy = static_cast<int>(seed_at(seed).y()) / kCellPx;
    if (cx >= cells.x0 && cx < cells.x1 && cy >= cells.y0 && cy < cells.y1) {
      offer(cx, cy, seed);
    }
  }
  const auto offer_from = [&](int cx, int cy, int dx, int dy) {
    if (cx + dx >= cells.x0 && cx + dx < cells.x1 && cy + dy >= cells.y0 && cy + dy < cells.y1) {
      offer(cx, cy, nearest_seed(cx + dx, cy + dy));
    }
  };
  const auto sweep_row = [&](int cy, int dy) {
    for (int cx = cells.x0; cx < cells.x1; ++cx) {
      offer_from(cx, cy, -1, dy);
      offer_from(cx, cy, 0, dy);
      offer_from(cx, cy, 1, dy);
      offer_from(cx, cy, -1, 0);
    }
    for (int cx = cells.x1; cx-- > cells.x0;) {
      offer_from(cx, cy, 1, 0);
    }
  };
  for (int cy = cells.y0; cy < cells.y1; ++cy) {
    sweep_row(cy, -1);
  }
  for (int cy = cells.y1; cy-- > cells.y0;) {
    sweep_row(cy, 1);
  }
}

// Boxes and areas as they came out, nearer regions on top; what is too small goes back to the background.
void RegionMask::measure() {
  for (int y = 0; y < labels_.height; ++y) {
    const std::uint8_t* row = labels_.row(y);
    for (int x = 0; x < labels_.width; x += kCellPx) {
      if (row[x] != kBackgroundLabel) {
        Detection& detection = detections_[row[x] - 1U];
        const int end = std::min(x + kCellPx, labels_.width);
        detection.area_px += end - x;
        detection.box_px.include(x, y);
        detection.box_px.include(end - 1, y);
      }
    }
  }
  std::array<std::uint8_t, 256> new_label{};
  std::size_t kept = 0;
  for (std::size_t k = 0; k < detections_.size(); ++k) {
    if (detections_[k].area_px >= min_area_px_) {
      detections_[kept] = detections_[k];
      region_of_label_[kept + 1] = region_of_label_[k + 1];
      detections_[kept].label = static_cast<std::uint8_t>(kept + 1);
      new_label[k + 1] = detections_[kept].label;
      ++kept;
    }
  }
  if (kept == detections_.size()) {
    return;
  }
  detections_.resize(kept);
  for (int y = 0; y < labels_.height; ++y) {
    std::uint8_t* row = labels_.row(y);
    std::transform(row, row + labels_.width, row, [&](std::uint8_t label) { return new_label[label]; });
  }
}

}  // namespace kinetrace::segmentation
