// Rotation and camera matrix of the rectification of each view.
#pragma once

#include <Eigen/Core>

#include "kinetrace/core/result.hpp"
#include "kinetrace/core/stereo_geometry.hpp"
#include "kinetrace/hal/rectifier.hpp"
#include "kinetrace/hal/rig_calibration.hpp"

namespace kinetrace::hal {

struct RectificationPlan {
  RigCalibration calibration;  ///< Validated.
  StereoGeometry geometry;     ///< Of the result; its camera matrix is that of both views.
  Eigen::Matrix3d R_left = Eigen::Matrix3d::Identity();
  Eigen::Matrix3d R_right = Eigen::Matrix3d::Identity();
  bool passes_through = false;  ///< The images are rectified already.
};

[[nodiscard]] Result<RectificationPlan> plan_rectification(const RigCalibration& calibration,
                                                           const RectifierConfig& config);

}  // namespace kinetrace::hal
