// Whether a measured velocity is that of something at rest.
#pragma once

#include <Eigen/Core>

namespace kinetrace::objects {

/// What the velocity of something at rest appears to be, besides its covariance.
inline constexpr double kRestSpeed_mps = 0.05;

/// Log-likelihood ratio of moving against rest for a velocity measured with `covariance` (m/s)^2: the velocity of
/// something at rest is zero, that of something moving has any direction and a speed of any order from a slow walk to a
/// car's (a mixture of normal distributions, each order as probable). Positive: rather moving. Undecided where the
/// measurement does not tell.
[[nodiscard]] double moving_evidence(const Eigen::Vector3d& velocity_mps, const Eigen::Matrix3d& covariance) noexcept;

}  // namespace kinetrace::objects
