#include "kinetrace/segmentation/region_mask.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include <Eigen/LU>

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
/// 97 % of three normal variables squared.
constexpr float kDistinctChi2 = 9.F;
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

float nearest_sq(std::span<const Eigen::Vector2f> points, const Eigen::Vector2f& p) noexcept {
  float best = std::numeric_limits<float>::max();
  for (const Eigen::Vector2f& q : points) {
    best = std::min(best, (q - p).squaredNorm());
  }
  return best;
}

/// Inside the convex polygon.
bool within(std::span<const Eigen::Vector2f> hull, const Eigen::Vector2f& p) noexcept {
  for (std::size_t i = 0; i < hull.size(); ++i) {
    const Eigen::Vector2f edge = hull[(i + 1) % hull.size()] - hull[i];
    const Eigen::Vector2f to_p = p - hull[i];
    if (edge.x() * to_p.y() - edge.y() * to_p.x() < 0.F) {
      return false;
    }
  }
  return true;
}

}  // namespace

RegionMask::RegionMask(const StereoGeometry& geometry, int max_features, int max_objects, int min_area_px, Arena& arena)
    : geometry_(geometry), min_area_px_(min_area_px) {
  const auto n = static_cast<std::size_t>(max_features);
  labels_ = take_image<std::uint8_t>(arena, geometry.width_px, geometry.height_px);
  detections_ = FixedVector<Detection>(arena, static_cast<std::size_t>(max_objects));
  outlines_ = FixedVector<Outline>(arena, MotionMemory::kMaxRegions);
  inherited_ = FixedVector<std::uint32_t>(arena, n);
  members_ = FixedVector<Eigen::Vector2f>(arena, n);
  rim_ = FixedVector<Eigen::Vector2f>(arena, kRimDirections * n);
  others_ = FixedVector<Eigen::Vector2f>(arena, n);
  hull_ = FixedVector<Eigen::Vector2f>(arena, 2 * kRimDirections * n + 2);
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
    if (memory.believes_outline(r, outline.area_px)) {
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
      const Eigen::Vector3f difference = motions[i].velocity_mps - region.velocity_mps;
      const Eigen::Matrix3f covariance = motions[i].covariance + region.covariance + 0.1F * Eigen::Matrix3f::Identity();
      distinct = difference.dot(covariance.inverse() * difference) > kDistinctChi2;
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
  Eigen::Vector2f low = hull_[0];
  Eigen::Vector2f high = hull_[0];
  for (const Eigen::Vector2f& p : hull_) {
    low = low.cwiseMin(p);
    high = high.cwiseMax(p);
  }
  const int x0 = std::max(0, static_cast<int>(low.x()) / kCellPx * kCellPx);
  const int y0 = std::max(0, static_cast<int>(low.y()) / kCellPx * kCellPx);
  for (int y = y0; y < labels_.height && static_cast<float>(y) <= high.y(); y += kCellPx) {
    for (int x = x0; x < labels_.width && static_cast<float>(x) <= high.x(); x += kCellPx) {
      const Eigen::Vector2f center(static_cast<float>(x) + 0.5F * (kCellPx - 1),
                                   static_cast<float>(y) + 0.5F * (kCellPx - 1));
      if (!within(hull_.span(), center) || nearest_sq(members_.span(), center) > nearest_sq(others_.span(), center)) {
        continue;
      }
      for (int row = y; row < std::min(y + kCellPx, labels_.height); ++row) {
        std::fill(labels_.row(row) + x, labels_.row(row) + std::min(x + kCellPx, labels_.width), outline.label);
      }
    }
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
