#include "kinetrace/tracking/disparity_plane.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>

#include <Eigen/Dense>

#include "kinetrace/core/quantiles.hpp"

namespace kinetrace::tracking {
namespace {

constexpr std::size_t kMinPlaneSamples = 6;
/// Steeper than any object face that both views see.
constexpr float kMaxSlope = 0.5F;

bool agrees(const DisparityPlane& plane, float tolerance_px, const DisparitySample& sample) noexcept {
  const float expected = plane.mean_px + plane.slope.dot(sample.left_px - plane.center_px);
  return std::abs(sample.disparity_px - expected) <= tolerance_px;
}

/// Least squares over the samples within `tolerance_px` of `start`; `start` itself if they are too few.
DisparityPlane refit(std::span<const DisparitySample> samples, const DisparityPlane& start, float tolerance_px) {
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();  // x, y, disparity
  std::size_t n = 0;
  for (const DisparitySample& s : samples) {
    if (agrees(start, tolerance_px, s)) {
      sum += Eigen::Vector3d(s.left_px.x(), s.left_px.y(), s.disparity_px);
      ++n;
    }
  }
  if (n < kMinPlaneSamples) {
    return start;
  }
  const Eigen::Vector3d mean = sum / static_cast<double>(n);
  Eigen::Matrix2d spread = Eigen::Matrix2d::Zero();
  Eigen::Vector2d correlation = Eigen::Vector2d::Zero();
  for (const DisparitySample& s : samples) {
    if (agrees(start, tolerance_px, s)) {
      const Eigen::Vector2d q = s.left_px.cast<double>() - mean.head<2>();
      spread += q * q.transpose();
      correlation += q * (static_cast<double>(s.disparity_px) - mean.z());
    }
  }
  // A ridge of n * (8 px)^2 keeps the slope at zero across directions in which the points hardly spread.
  spread.diagonal().array() += 64.0 * static_cast<double>(n);
  DisparityPlane plane = start;
  plane.center_px = mean.head<2>().cast<float>();
  plane.mean_px = static_cast<float>(mean.z());
  plane.slope = spread.inverse().operator*(correlation).cast<float>().cwiseMax(-kMaxSlope).cwiseMin(kMaxSlope);
  return plane;
}

}  // namespace

DisparityPlane fit_disparity(std::span<const DisparitySample> samples, std::span<float> scratch) {
  DisparityPlane plane;
  if (samples.empty()) {
    return plane;
  }
  const std::span<float> values = scratch.first(samples.size());
  std::transform(samples.begin(), samples.end(), values.begin(),
                 [](const DisparitySample& s) { return s.disparity_px; });
  plane.known = true;
  plane.mean_px = median(values);
  // A quarter of the disparity spans any vehicle seen from more than its own length away.
  const float tolerance_px = std::max(2.0F, 0.25F * plane.mean_px);
  for (const DisparitySample& s : samples) {
    plane.center_px += s.left_px / static_cast<float>(samples.size());
  }
  plane = refit(samples, plane, tolerance_px);
  plane = refit(samples, plane, std::max(1.5F, 0.1F * plane.mean_px));
  plane.min_px = plane.max_px = plane.mean_px;
  for (const DisparitySample& s : samples) {
    if (agrees(plane, tolerance_px, s)) {
      plane.min_px = std::min(plane.min_px, s.disparity_px);
      plane.max_px = std::max(plane.max_px, s.disparity_px);
    }
  }
  return plane;
}

}  // namespace kinetrace::tracking
