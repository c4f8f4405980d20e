#include "kinetrace/segmentation/candidate_filter.hpp"

#include <algorithm>

#include "kinetrace/core/detections.hpp"
#include "kinetrace/segmentation/mask_canvas.hpp"
#include "kinetrace/segmentation/person_size.hpp"

namespace kinetrace::segmentation {
namespace {

/// Least features that determine a mask's disparity.
constexpr std::size_t kMinFeatures = 4;

}  // namespace

CandidateFilter::CandidateFilter(const StereoGeometry& geometry, int max_features, Arena& arena)
    : baseline_m_(static_cast<float>(geometry.baseline_m)),
      points_(arena, static_cast<std::size_t>(max_features)),
      samples_(arena, static_cast<std::size_t>(max_features)),
      inside_px_(arena, static_cast<std::size_t>(max_features)),
      plausible_(arena, MaskCanvas::kMaxMasks) {}

void CandidateFilter::remember(std::span<const Feature> features) noexcept {
  points_.clear();
  for (const Feature& feature : features) {
    if (feature.has_right()) {
      static_cast<void>(  // as many places as features
          points_.push_back({feature.left_px.array().round().cast<int>(), feature.disparity_px()}));
    }
  }
}

float CandidateFilter::near_disparity_px(const RunLengthMask& mask) noexcept {
  const PixelBox& box = mask.box_px;
  samples_.clear();
  for (const Point& point : points_) {
    if (point.pixel.x() >= box.x0 && point.pixel.x() < box.x1 && point.pixel.y() >= box.y0 &&
        point.pixel.y() < box.y1) {
      const int at = (point.pixel.y() - box.y0) * box.width() + point.pixel.x() - box.x0;
      static_cast<void>(samples_.push_back({static_cast<std::uint32_t>(at), point.disparity_px}));
    }
  }
  std::sort(samples_.begin(), samples_.end(), [](const Sample& a, const Sample& b) { return a.at < b.at; });
  inside_px_.clear();
  const Sample* sample = samples_.begin();
  std::uint32_t end = 0;
  bool inside = false;
  for (const std::uint16_t run : mask.runs) {
    end += run;
    for (; sample != samples_.end() && sample->at < end; ++sample) {
      if (inside) {
        static_cast<void>(inside_px_.push_back(sample->disparity_px));
      }
    }
    inside = !inside;
  }
  if (inside_px_.size() < kMinFeatures) {
    return 0.F;
  }
  const auto upper_quartile = inside_px_.begin() + static_cast<std::ptrdiff_t>(3 * inside_px_.size() / 4);
  std::nth_element(inside_px_.begin(), upper_quartile, inside_px_.end());
  return *upper_quartile;
}

std::span<const RunLengthMask> CandidateFilter::plausible(std::span<const RunLengthMask> candidates) noexcept {
  plausible_.clear();
  for (const RunLengthMask& mask : candidates.first(std::min(candidates.size(), plausible_.capacity()))) {
    const float disparity_px = mask.class_id == kPedestrianClass ? near_disparity_px(mask) : 0.F;
    if (disparity_px <= 0.F || !is_larger_than_people(mask.box_px, disparity_px, baseline_m_)) {
      static_cast<void>(plausible_.push_back(mask));
    }
  }
  return plausible_.span();
}

}  // namespace kinetrace::segmentation
