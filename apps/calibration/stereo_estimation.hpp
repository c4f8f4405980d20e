// Estimates both lenses and the pose between them from views of a target: bundle adjustment with covariance.
#pragma once

#include <array>
#include <cstddef>
#include <span>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "detector.hpp"
#include "kinetrace/core/result.hpp"
#include "kinetrace/hal/rig_calibration.hpp"
#include "lens.hpp"

namespace kinetrace::calibration {

struct EstimationOptions {
  Lens lens = Lens::kRadialTangential;
  int width_px = 0;
  int height_px = 0;
  int threads = 2;
};

/// A corner and its residual.
struct Residual {
  std::size_t view = 0;
  bool is_left = true;
  Eigen::Vector2d px;        ///< Where it was measured.
  Eigen::Vector2d error_px;  ///< Projected minus measured.
};

/// Names of the parameters: fx fy cx cy and eight coefficients of either camera, then rotation and translation.
inline constexpr int kCameraParameters = 12;
inline constexpr int kParameters = 2 * kCameraParameters + 6;
using ParameterVector = Eigen::Matrix<double, kParameters, 1>;
using ParameterMatrix = Eigen::Matrix<double, kParameters, kParameters>;
[[nodiscard]] std::string parameter_name(int index);

struct StereoEstimate {
  hal::RigCalibration rig;
  /// In the order of parameter_name; the last six are of T_right_left under left_update (rad, m). Rows and columns of
  /// parameters that were not estimated are zero. Scaled by the final residuals.
  ParameterMatrix covariance = ParameterMatrix::Zero();
  double left_rms_px = 0.0;  ///< Of a corner's distance, both axes together.
  double right_rms_px = 0.0;
  double sigma_px = 0.0;                ///< Of one coordinate of a corner, from the residuals.
  std::vector<Se3> T_left_board;        ///< By view, of those used.
  std::vector<std::size_t> used_views;  ///< Indices into the given views.
  std::size_t rejected_views = 0;
  std::size_t rejected_corners = 0;
  std::vector<Residual> residuals;  ///< Of the corners used; `view` is an index into the given views.

  [[nodiscard]] ParameterVector sigmas() const { return covariance.diagonal().cwiseMax(0.0).cwiseSqrt(); }
  /// Relative standard deviation of the focal length, the larger one of both cameras.
  [[nodiscard]] double relative_focal_sigma() const;
  /// Of the rotation between the views, the largest of the axes.
  [[nodiscard]] double rotation_sigma_rad() const { return sigmas().tail<6>().head<3>().maxCoeff(); }
};

/// Tolerates bad views: outlier corners or whole views are rejected. Errors: kBadCalibration, with the remedy (too few
/// views; no solution).
[[nodiscard]] Result<StereoEstimate> estimate_stereo(const Target& target, std::span<const BoardView> views,
                                                     const EstimationOptions& options);

}  // namespace kinetrace::calibration
