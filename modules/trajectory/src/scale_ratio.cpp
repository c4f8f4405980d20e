#include "kinetrace/trajectory/scale_ratio.hpp"

#include <algorithm>
#include <cmath>

#include "median.hpp"

namespace kinetrace::trajectory {
namespace {

bool is_length(double value) {
  return std::isfinite(value) && value > 0.0;
}

}  // namespace

ScaleRatio estimate_scale_ratio(std::span<const double> object_baselines, std::span<const double> background_baselines,
                                std::span<double> scratch) noexcept {
  const std::size_t frames = std::min({object_baselines.size(), background_baselines.size(), scratch.size()});
  ScaleRatio scale;
  for (std::size_t i = 0; i < frames; ++i) {
    if (is_length(object_baselines[i]) && is_length(background_baselines[i])) {
      scratch[scale.frames++] = background_baselines[i] / object_baselines[i];
    }
  }
  if (scale.frames == 0) {
    return scale;
  }
  const std::span<double> ratios = scratch.first(scale.frames);
  scale.ratio = median(ratios);
  for (double& ratio : ratios) {
    ratio = std::abs(ratio - scale.ratio);
  }
  // The median of Gaussian samples scatters sqrt(pi / 2) times as much as their mean.
  constexpr double kMedianLoss = 1.2533;
  scale.sigma = kMedianLoss * kSigmaOverMad * median(ratios) / std::sqrt(static_cast<double>(scale.frames));
  return scale;
}

Se3 scaled(const Se3& T_obj_cam, const ScaleRatio& scale) {
  return {T_obj_cam.rotation, scale.ratio * T_obj_cam.translation};
}

Eigen::Vector3d scaled(const Eigen::Vector3d& p_obj, const ScaleRatio& scale) {
  return scale.ratio * p_obj;
}

}  // namespace kinetrace::trajectory
