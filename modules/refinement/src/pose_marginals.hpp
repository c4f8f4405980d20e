// Covariances of the poses of a batch problem, points marginalised.
#pragma once

#include <cstddef>
#include <vector>

#include <ceres/crs_matrix.h>

#include "kinetrace/core/se3.hpp"

namespace kinetrace::refinement {

/// Pose blocks of the inverse of J^T J. The columns of J are points (3 each), then poses (6 each); a row depends on at
/// most one point. Points are eliminated first (Schur complement; Triggs et al. 2000, sec. 6.1); the rest is dense: 8
/// (6 poses)^2 bytes, and time grows with the cube of the poses. An unobserved pose has the covariance of a weak prior
/// (10^3 rad, 10^3 m).
[[nodiscard]] std::vector<Matrix6d> marginal_pose_covariances(const ceres::CRSMatrix& jacobian, std::size_t points,
                                                              std::size_t poses);

}  // namespace kinetrace::refinement
