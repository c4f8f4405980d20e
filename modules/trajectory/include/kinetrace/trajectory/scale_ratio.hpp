// Scale between an object's and the background's reconstruction (Bullinger et al. 2018, sec. 2.2).
#pragma once

#include <cstddef>
#include <span>

#include <Eigen/Core>

#include "kinetrace/core/se3.hpp"

namespace kinetrace::trajectory {

/// Each reconstruction of an uncalibrated rig has its own unit of length. Both contain the same stereo baseline, so
/// its lengths in the two tell the ratio of the units.
struct ScaleRatio {
  double ratio = 1.0;      ///< Lengths of the object reconstruction times this are lengths of the background's.
  double sigma = 0.0;      ///< Standard deviation of the ratio, from the spread over frames.
  std::size_t frames = 0;  ///< Frames with a usable pair; with none the ratio is 1.
};

/// Median over frames of background baseline / object baseline. Frames where either is not finite or not positive (no
/// pose: the pair does not count, paper) are left out. Needs `scratch` of the number of frames.
[[nodiscard]] ScaleRatio estimate_scale_ratio(std::span<const double> object_baselines,
                                              std::span<const double> background_baselines,
                                              std::span<double> scratch) noexcept;

/// T_obj_cam with its translation in the background's unit.
[[nodiscard]] Se3 scaled(const Se3& T_obj_cam, const ScaleRatio& scale);
/// An object point in the background's unit.
[[nodiscard]] Eigen::Vector3d scaled(const Eigen::Vector3d& p_obj, const ScaleRatio& scale);

}  // namespace kinetrace::trajectory
