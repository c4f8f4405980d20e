// Cramer-Rao bound of an object's trajectory.
#pragma once

#include <vector>

#include "kinetrace/core/body_velocity.hpp"
#include "kinetrace/core/stereo_geometry.hpp"
#include "study/pixel_noise.hpp"
#include "study/visible_points.hpp"

namespace kinetrace::app {

/// Least standard deviations in one view: roots of the traces of covariances.
struct PoseBound {
  double place_m = 0.0;     ///< Of the box's centre, after the constant offset in the object that fits all views best.
  double motion_m = 0.0;    ///< From the view before; zero in the first one.
  double motion_deg = 0.0;  ///< ... its rotation.
};

/// Cramer-Rao bound of the object's poses in all views, one for each. It holds for every unbiased estimator, online or
/// batch.
///
/// Unknowns: the poses T_k = L_k Exp(xi_k), with true poses L_k, and the positions X_j of the points in the object; the
/// camera is known. With the Jacobian H_kj of (u_left, v, disparity) by X_j, their noise N, and D_j = (-[X_j]x, I):
///
///   M_kj = H_kj^T N^-1 H_kj,   U_j = sum_k M_kj
///   J_kl = delta_kl sum_j D_j^T M_kj D_j - sum_j D_j^T M_kj U_j^-1 M_lj D_j + P_kl
///
/// is the Fisher information of the poses once points are eliminated (bundle adjustment's reduced normal equations;
/// Triggs et al. 2000), P that of the prior: MotionPrior, and no more than 50 m/s and 10 rad/s. With a
/// prior the bound is van Trees' (1968; for sequences Tichavsky, Muravchik, Nehorai 1998), at
/// the true path. The first pose is the object's frame. Motion has the covariance of xi_k - xi_k-1: exactly the error
/// that ObjectErrors::motion measures.
[[nodiscard]] std::vector<PoseBound> pose_bounds(const SeenBody& body, const StereoGeometry& geometry,
                                                 const PixelNoise& noise, const MotionPrior& prior);

}  // namespace kinetrace::app
