#include "stereo_sighting.hpp"

#include <algorithm>
#include <array>
#include <cstddef>
#include <span>

namespace kinetrace::pipeline {
namespace {

constexpr std::size_t kMaxSightedFeatures = 256;  // Medians over more than this are no better.

double median(std::span<double> values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

}  // namespace

StereoSighting sight(const FeatureFrame& frame, std::uint8_t label, double min_disparity_px) {
  std::array<double, kMaxSightedFeatures> u;
  std::array<double, kMaxSightedFeatures> v;
  std::array<double, kMaxSightedFeatures> d;
  std::size_t count = 0;
  for (const Feature& feature : frame.features) {
    if (feature.body == label && feature.has_right() && double{feature.disparity_px()} >= min_disparity_px &&
        count < kMaxSightedFeatures) {
      u[count] = double{feature.left_px.x()};
      v[count] = double{feature.v_px};
      d[count++] = double{feature.disparity_px()};
    }
  }
  StereoSighting sighting;
  sighting.features = static_cast<int>(count);
  if (count > 0) {
    sighting.uvd_px = {median(std::span(u).first(count)), median(std::span(v).first(count)),
                       median(std::span(d).first(count))};
  }
  return sighting;
}

Eigen::Vector3d position_in_camera(const StereoGeometry& geometry, const StereoSighting& sighting) {
  return geometry.triangulate(sighting.uvd_px.x(), sighting.uvd_px.y(), sighting.uvd_px.z());
}

double mean_column(LabelView labels, const PixelBox& box, std::uint8_t label) {
  std::int64_t sum = 0;
  std::int64_t count = 0;
  for (int y = std::max(box.y0, 0); y < std::min(box.y1, labels.height); ++y) {
    const std::uint8_t* const row = labels.row(y);
    for (int x = std::max(box.x0, 0); x < std::min(box.x1, labels.width); ++x) {
      const int own = row[x] == label ? 1 : 0;
      sum += own * x;
      count += own;
    }
  }
  return count > 0 ? static_cast<double>(sum) / static_cast<double>(count) : 0.5 * (box.x0 + box.x1 - 1);
}

}  // namespace kinetrace::pipeline
