#include "stereo_sighting.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <span>

namespace kinetrace::pipeline {
namespace {

constexpr std::size_t kMaxSightedFeatures = 256;  // Medians over more than this are no better.
// How far the patch of a feature reaches.
constexpr int kBesideX_px = 8;
constexpr int kBesideY_px = 5;
constexpr double kClearlyNearer = 1.1;

double median(std::span<double> values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

/// The objects whose masks adjoin that of one.
class Occluders {
 public:
  Occluders(const FeatureFrame& frame, LabelView labels, std::uint8_t label)
      : frame_(frame), labels_(labels), own_(label) {}

  /// The feature lies along the contour of an object that is as near as it, or nearer.
  [[nodiscard]] bool may_have(const Feature& feature) {
    if (labels_.empty()) {
      return false;
    }
    const auto x = static_cast<int>(std::lround(feature.left_px.x()));
    const auto y = static_cast<int>(std::lround(feature.left_px.y()));
    const std::array<std::uint8_t, 4> beside{label_at(x - kBesideX_px, y), label_at(x + kBesideX_px, y),
                                             label_at(x, y - kBesideY_px), label_at(x, y + kBesideY_px)};
    return std::any_of(beside.begin(), beside.end(), [&](std::uint8_t other) {
      return other != own_ && other != kBackgroundLabel && other != kIgnoreLabel &&
             double{feature.disparity_px()} < kClearlyNearer * disparity_of(other);
    });
  }

 private:
  [[nodiscard]] std::uint8_t label_at(int x, int y) const {
    return labels_.at(std::clamp(x, 0, labels_.width - 1), std::clamp(y, 0, labels_.height - 1));
  }
  /// Median; 0 if nothing of it is seen.
  [[nodiscard]] double disparity_of(std::uint8_t other) {
    if (other != known_) {
      std::array<double, kMaxSightedFeatures> d;
      std::size_t count = 0;
      for (const Feature& feature : frame_.features) {
        if (feature.body == other && feature.has_right() && count < d.size()) {
          d[count++] = double{feature.disparity_px()};
        }
      }
      known_ = other;
      known_disparity_px_ = count > 0 ? median(std::span(d).first(count)) : 0.0;
    }
    return known_disparity_px_;
  }

  const FeatureFrame& frame_;
  LabelView labels_;
  std::uint8_t own_;
  std::uint8_t known_ = kBackgroundLabel;
  double known_disparity_px_ = 0.0;
};

}  // namespace

StereoSighting sight(const FeatureFrame& frame, LabelView labels, std::uint8_t label, double min_disparity_px) {
  Occluders occluders(frame, labels, label);
  std::array<double, kMaxSightedFeatures> u;
  std::array<double, kMaxSightedFeatures> v;
  std::array<double, kMaxSightedFeatures> d;
  std::size_t count = 0;
  for (const Feature& feature : frame.features) {
    if (feature.body == label && feature.has_right() && double{feature.disparity_px()} >= min_disparity_px &&
        count < kMaxSightedFeatures && !occluders.may_have(feature)) {
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
