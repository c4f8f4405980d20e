// Evidence of motion in a measured velocity.
#pragma once

#include <Eigen/Core>

namespace kinetrace::objects {

/// Log-likelihood ratio of moving against rest for a velocity measured with `covariance` (m/s)^2. At rest the velocity
/// is zero; moving it has any direction, and a speed between a slow walk and a car (a mixture of normal distributions
/// with equal weights). Positive: rather moving. Near zero if the measurement does not discriminate.
[[nodiscard]] double moving_evidence(const Eigen::Vector3d& velocity_mps, const Eigen::Matrix3d& covariance) noexcept;

}  // namespace kinetrace::objects
