// Object and background reconstruction combined (Bullinger et al. 2018, eq. 2).
#pragma once

#include <span>

#include "kinetrace/core/se3.hpp"

namespace kinetrace::trajectory {

/// A pose and its covariance, left perturbation (rad, m).
struct PoseWithCovariance {
  Se3 pose;
  Matrix6d covariance = Matrix6d::Zero();
};

/// T_world_obj = T_world_cam * T_obj_cam^-1, the two errors taken as independent.
[[nodiscard]] PoseWithCovariance compose(const PoseWithCovariance& T_world_cam, const PoseWithCovariance& T_obj_cam);

/// Eq. 2 for one point: camera frame of the object reconstruction, then world.
[[nodiscard]] Eigen::Vector3d object_point_in_world(const Se3& T_world_cam, const Se3& T_obj_cam,
                                                    const Eigen::Vector3d& p_obj);

}  // namespace kinetrace::trajectory
