// How far a self-calibration can be off, and what that does to depths.
#pragma once

#include <vector>

#include <Eigen/Core>

#include "rig_bundle.hpp"

namespace kinetrace::self_calibration {

using RigCovariance = Eigen::Matrix<double, kRigSize, kRigSize>;

/// Covariance of left lens, right lens, mount. Formal covariance, from observations taken as independent, plus that of
/// the windows' scatter: how much the estimate would change with other windows, by the sandwich formula with windows as
/// clusters (Liang and Zeger, Biometrika 1986), which sees errors that observations of a window share. The sum, since
/// a few windows tell their scatter only roughly and the formal part alone is too small.
[[nodiscard]] RigCovariance rig_covariance(const RigModel& rig, const std::vector<BundleWindow>& windows,
                                           const BundleOptions& options);

/// Standard deviation of ln(fx), of the worse lens.
[[nodiscard]] double focal_sigma(const RigCovariance& covariance);

/// Standard deviation of a depth that this rig measures, as a part of it, from the rig's own error: root mean square
/// over the image.
[[nodiscard]] double depth_sigma(const RigModel& rig, const RigCovariance& covariance, double depth_m);

}  // namespace kinetrace::self_calibration
