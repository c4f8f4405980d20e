// Uncertainty of a self-calibration, and its effect on depths.
#pragma once

#include <vector>

#include <Eigen/Core>

#include "rig_bundle.hpp"

namespace kinetrace::self_calibration {

using RigCovariance = Eigen::Matrix<double, kRigSize, kRigSize>;

/// Covariance of left lens, right lens, mount. Sum of the formal covariance, with independent observations, and that of
/// the windows' scatter: the change of the estimate with other windows, by the sandwich formula with windows as
/// clusters (Liang and Zeger, Biometrika 1986), which includes errors common to a window. The sum, because a few
/// windows give only a rough scatter and the formal part alone is too small.
[[nodiscard]] RigCovariance rig_covariance(const RigModel& rig, const std::vector<BundleWindow>& windows,
                                           const BundleOptions& options);

/// Standard deviation of ln(fx), of the worse lens.
[[nodiscard]] double focal_sigma(const RigCovariance& covariance);

/// Relative standard deviation of a depth measured with this rig, caused by the rig's own error: root mean square over
/// the image.
[[nodiscard]] double depth_sigma(const RigModel& rig, const RigCovariance& covariance, double depth_m);

}  // namespace kinetrace::self_calibration
