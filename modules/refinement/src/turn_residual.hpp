// How far a body has turned between two frames of a window, against what is expected of it.
#pragma once

#include <Eigen/Core>

#include "kinetrace/core/bundle.hpp"
#include "kinetrace/core/se3.hpp"

namespace kinetrace::refinement {

/// Threshold of the Cauchy loss on a turn, in sigmas: most bodies hardly turn, and those that do, turn many times
/// faster. Beyond it the pull towards not turning grows weaker, so it costs them next to nothing.
inline constexpr double kTurnThreshold = 1.0;

/// In sigmas, about the axes of the later camera; the rotations are those of T_cam_body (or of any frame fixed to the
/// body) in the two frames. Under left perturbations of these it changes by inverse_sigma_rad times
/// R_before_now^T xi_before - xi_now, as long as the turn is small; the gradient of its square is exact.
[[nodiscard]] inline Eigen::Vector3d turn_residual(const TurnPrior& prior, const Eigen::Matrix3d& R_before_body,
                                                   const Eigen::Matrix3d& R_now_body) {
  return prior.inverse_sigma_rad * so3_log(prior.R_before_now.transpose() * R_before_body * R_now_body.transpose());
}

}  // namespace kinetrace::refinement
