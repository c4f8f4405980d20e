// Residual of a body's rotation between two frames of a window, against its prior.
#pragma once

#include <Eigen/Core>

#include "kinetrace/core/bundle.hpp"
#include "kinetrace/core/se3.hpp"

namespace kinetrace::refinement {

/// Threshold of the Cauchy loss on a turn, in sigmas: most bodies hardly turn, others turn many times faster. Beyond it
/// the prior weakens, so that it hardly affects turning bodies.
inline constexpr double kTurnThreshold = 1.0;

/// In sigmas, about the axes of the later camera; the rotations are those of T_cam_body (or of any frame fixed to the
/// body) in the two frames. For small turns its derivative by left perturbations of these is inverse_sigma_rad times
/// (R_before_now^T xi_before - xi_now); the gradient of its square is exact.
[[nodiscard]] inline Eigen::Vector3d turn_residual(const TurnPrior& prior, const Eigen::Matrix3d& R_before_body,
                                                   const Eigen::Matrix3d& R_now_body) {
  return prior.inverse_sigma_rad * so3_log(prior.R_before_now.transpose() * R_before_body * R_now_body.transpose());
}

}  // namespace kinetrace::refinement
