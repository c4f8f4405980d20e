// Covariance of the newest pose of a window in double precision.
#pragma once

#include "kinetrace/core/bundle.hpp"

namespace kinetrace::refinement {

/// Marginal covariance of the last pose (left perturbation of T_body_cam) at the window's current state, points and
/// other free poses integrated out, robust weights of `robust_threshold` applied. Zero if the last pose is fixed; the
/// inverse of a tiny prior if it is unobserved.
[[nodiscard]] Matrix6d newest_marginal_covariance(const BundleWindow& window, double robust_threshold);

}  // namespace kinetrace::refinement
