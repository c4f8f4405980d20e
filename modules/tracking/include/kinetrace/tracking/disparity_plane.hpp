// An object's disparity over its mask: carries the left mask into the right image.
#pragma once

#include <span>

#include <Eigen/Core>

namespace kinetrace::tracking {

/// d(x, y) = mean + slope . ((x, y) - center), limited to what was seen.
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

/// Median and, where enough points lie far enough apart, a plane fitted to the points near it. `scratch` holds at least
/// samples.size() values. No samples: not known.
[[nodiscard]] DisparityPlane fit_disparity(std::span<const DisparitySample> samples, std::span<float> scratch);

}  // namespace kinetrace::tracking
