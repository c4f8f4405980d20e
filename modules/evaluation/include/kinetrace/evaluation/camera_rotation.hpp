// A constant rotation between the camera's estimated frame and the true one.
#pragma once

#include <span>

#include <Eigen/Core>

#include "kinetrace/evaluation/camera_metrics.hpp"

namespace kinetrace::evaluation {

/// The rotation R for which the motion of T_world_cam * R is most similar to that of T_world_cam_true: truth of the raw
/// camera differs by the rectifying rotation, which no run records. Least squares over the displacements and rotations
/// within ten frames, in the camera's frame (Arun et al., PAMI 1987). Identity if there are fewer frames, or no
/// movement in two directions.
[[nodiscard]] Eigen::Matrix3d camera_rotation(std::span<const PosePair> pairs);

}  // namespace kinetrace::evaluation
