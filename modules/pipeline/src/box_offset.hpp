// Where a point lies relative to a box.
#pragma once

#include "kinetrace/core/frame_result.hpp"
#include "kinetrace/core/se3.hpp"

namespace kinetrace::pipeline {

/// From the nearest point of the box to `point_m`, both in the frame that the box is given in; zero inside it.
[[nodiscard]] inline Eigen::Vector3d outside_of(const Box3& box, const Eigen::Vector3d& point_m) {
  const Eigen::Matrix3d turn = so3_exp(Eigen::Vector3d(0.0, box.yaw_rad, 0.0));
  const Eigen::Vector3d at_m = turn.transpose() * (point_m - box.center_m);
  const Eigen::Vector3d half_m = 0.5 * box.size_m;
  return turn * (at_m - at_m.cwiseMax(-half_m).cwiseMin(half_m));
}

}  // namespace kinetrace::pipeline
