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
      samples_(arena, static_cast<std::size_t>(max_features)),
      inside_px_(arena, static_cast<std::size_t>(max_features)),
      plausible_(arena, MaskCanvas::kMaxMasks) {}

float CandidateFilter::near_disparity_px(const RunLengthMask& mask, std::span<const SeenFeature> features) noexcept {
  const PixelBox& box = mask.box_px;
  samples_.clear();
  for (const SeenFeature& feature : features) {
    const Eigen::Vector2i pixel = feature.left_px.array().round().cast<int>();
    if (feature.id != 0 && feature.has_right() && pixel.x() >= box.x0 && pixel.x() < box.x1 && pixel.y() >= box.y0 &&
        pixel.y() < box.y1) {
      const int at = (pixel.y() - box.y0) * box.width() + pixel.x() - box.x0;
      static_cast<void>(  // as many places as features
          samples_.push_back({static_cast<std::uint32_t>(at), feature.disparity_px()}));
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

std::span<const RunLengthMask> CandidateFilter::plausible(std::span<const RunLengthMask> candidates,
                                                          std::span<const SeenFeature> features) noexcept {
  plausible_.clear();
  for (const RunLengthMask& mask : candidates.first(std::min(candidates.size(), plausible_.capacity()))) {
    const float disparity_px = mask.class_id == kPedestrianClass ? near_disparity_px(mask, features) : 0.F;
    if (disparity_px <= 0.F || !is_larger_than_people(mask.box_px, disparity_px, baseline_m_)) {
      static_cast<void>(plausible_.push_back(mask));
    }
  }
  return plausible_.span();
}

}  // namespace kinetrace::segmentation
