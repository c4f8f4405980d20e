// Information of common points about the relative pose of two frames.
#pragma once

#include <span>

#include "kinetrace/core/se3.hpp"
#include "kinetrace/core/stereo_geometry.hpp"

namespace kinetrace::batch {

/// Inverse covariance of the left perturbation of T_a_b, by stereo reprojection of points `p_a_m` (camera frame of a)
/// that both frames observe with `sigma_px`: each frame adds its noise, hence twice the variance.
[[nodiscard]] Matrix6d pose_information(const StereoGeometry& geometry, std::span<const Eigen::Vector3d> p_a_m,
                                        double sigma_px);

}  // namespace kinetrace::batch
