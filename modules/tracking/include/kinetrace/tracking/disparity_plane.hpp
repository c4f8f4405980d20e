// Disparity of an object over its mask: maps the left mask to the right image.
#pragma once

#include <span>

#include <Eigen/Core>

namespace kinetrace::tracking {

/// d(x, y) = mean + slope . ((x, y) - center), clamped to the observed range.
struct DisparityPlane {
  bool known = false;
  float mean_px = 0.F;
  Eigen::Vector2f center_px{0.F, 0.F};
  Eigen::Vector2f slope{0.F, 0.F};
  float min_px = 0.F;
  float max_px = 0.F;
};

/// A left image point with its disparity.
struct DisparitySample {
  Eigen::Vector2f left_px{0.F, 0.F};
  float disparity_px = 0.F;
};

/// Median and, where enough samples are spread widely enough, a plane fitted to the inliers about it. `scratch` holds
/// at least samples.size() values. Without samples it is not known.
[[nodiscard]] DisparityPlane fit_disparity(std::span<const DisparitySample> samples, std::span<float> scratch);

}  // namespace kinetrace::tracking
