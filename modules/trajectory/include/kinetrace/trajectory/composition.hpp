// Object and background reconstruction combined (Bullinger et al. 2018, eq. 2).
#pragma once

#include <Eigen/Core>

#include "kinetrace/core/se3.hpp"

namespace kinetrace::trajectory {

/// A pose and its covariance, left perturbation (rad, m).
struct PoseWithCovariance {
  Se3 pose;
  Matrix6d covariance = Matrix6d::Zero();
};

/// T_world_obj = T_world_cam * T_obj_cam^-1, the two errors taken as independent.
[[nodiscard]] PoseWithCovariance compose(const PoseWithCovariance& T_world_cam, const PoseWithCovariance& T_obj_cam);

/// Covariance (m^2) of where `T_world_obj` puts the object point `p_obj`. Far from the world's origin this is not the
/// lower right block of the pose's covariance: there, rotation and translation errors go together.
[[nodiscard]] Eigen::Matrix3d point_covariance(const PoseWithCovariance& T_world_obj, const Eigen::Vector3d& p_obj);

/// Eq. 2 for one point: camera frame of the object reconstruction, then world.
[[nodiscard]] Eigen::Vector3d object_point_in_world(const Se3& T_world_cam, const Se3& T_obj_cam,
                                                    const Eigen::Vector3d& p_obj);

}  // namespace kinetrace::trajectory
