// A constant rotation between the camera's estimated frame and the true one.
#pragma once

#include <span>

#include <Eigen/Core>

#include "kinetrace/evaluation/camera_metrics.hpp"

namespace kinetrace::evaluation {

/// The rotation R with which T_world_cam * R moves most like T_world_cam_true: truth given for the raw camera differs
/// by the rectifying rotation, which no run records. Least squares over the displacements and turns within ten frames,
/// seen from the camera (Arun et al., PAMI 1987). Identity if there are fewer frames, or no movement in two directions.
[[nodiscard]] Eigen::Matrix3d camera_rotation(std::span<const PosePair> pairs);

}  // namespace kinetrace::evaluation
