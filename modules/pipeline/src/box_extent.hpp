// A box as the camera sees it: its extent in the image, its space by stereo.
#pragma once

#include <optional>

#include <Eigen/Core>

#include "kinetrace/core/box3.hpp"
#include "kinetrace/core/se3.hpp"
#include "kinetrace/core/stereo_geometry.hpp"
#include "kinetrace/tracking/prediction.hpp"

namespace kinetrace::pipeline {

/// Bounding rectangle of the box (world frame) in the left image, with the standard deviation of each side.
/// `position_covariance` (3x3, world axes, m^2) is that of the box beyond its own `sigma`. What lies behind the camera
/// is cut off; of a box wholly behind it nothing is known.
[[nodiscard]] std::optional<tracking::ImageExtent> image_extent(const Box3& box, const Box3Sigma& sigma,
                                                                const Eigen::Matrix3d& position_covariance,
                                                                const Se3& T_world_cam, const StereoGeometry& geometry);

/// The space inside that box, by the same covariances.
[[nodiscard]] tracking::PredictedVolume volume_of(const Box3& box, const Box3Sigma& sigma,
                                                  const Eigen::Matrix3d& position_covariance, const Se3& T_world_cam,
                                                  const StereoGeometry& geometry);

}  // namespace kinetrace::pipeline
