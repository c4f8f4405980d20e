// Pose of the rig relative to a body from known points: stereo 3-point RANSAC, then robust refinement.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include <Eigen/Core>

#include "kinetrace/core/arena.hpp"
#include "kinetrace/core/se3.hpp"
#include "kinetrace/core/stereo_geometry.hpp"

namespace kinetrace::sfm {

/// A body point and its observation by the rig; `u_right_px` is NaN without a right match.
struct PoseObservation {
  Eigen::Vector3d p_body = Eigen::Vector3d::Zero();
  float u_left_px = 0.F;
  float v_px = 0.F;
  float u_right_px = kNoRight;
  /// Variance of the reprojection error over that of a measurement: 1 for an exactly known point, 2 for one from a
  /// single earlier measurement.
  float variance_ratio = 1.F;
};

struct PoseEstimate {
  bool valid = false;  ///< False: fewer than three observations, or no hypothesis with three inliers.
  Se3 T_cam_body;
  Matrix6d covariance = Matrix6d::Zero();  ///< Of T_cam_body, left perturbation (rad, m).
  int inliers = 0;
  int agreeing_consensus = 0;  ///< Inliers among the consensus set.
};

/// Prior on the pose.
struct PosePrior {
  Se3 T_cam_body;
  Matrix6d information = Matrix6d::Zero();  ///< Of T_cam_body, left perturbation. Zero: an initial value only.
};

struct PoseEstimatorConfig {
  double gate_sigma = 4.0;
  int max_hypotheses = 96;
};

/// Minimises the robust stereo reprojection error over one pose.
///
/// Hypotheses come from three random points each, solved by Gauss-Newton on their stereo reprojection error: unlike
/// alignment of triangulated points, this weights far points by their information. The prior is the first hypothesis,
/// and takes part in ranking and refinement. Sampling is seeded by the number of observations: the same input gives the
/// same output.
class StereoPoseEstimator {
 public:
  StereoPoseEstimator(const PoseEstimatorConfig& config, const StereoGeometry& geometry)
      : config_(config), geometry_(geometry) {}

  /// `inlier` (as long as `observations`) receives 1 for observations that agree with the result, else 0. `sigma_px`:
  /// standard deviation of a measured coordinate. `consensus_size`: hypotheses are generated and ranked by so many of
  /// the first observations; the others only refine the selected one.
  [[nodiscard]] PoseEstimate estimate(std::span<const PoseObservation> observations, const PosePrior& prior,
                                      double sigma_px, std::span<std::uint8_t> inlier,
                                      std::size_t consensus_size) const;
  /// The same with all observations in the consensus set.
  [[nodiscard]] PoseEstimate estimate(std::span<const PoseObservation> observations, const PosePrior& prior,
                                      double sigma_px, std::span<std::uint8_t> inlier) const {
    return estimate(observations, prior, sigma_px, inlier, observations.size());
  }

 private:
  PoseEstimatorConfig config_;
  StereoGeometry geometry_;
};

/// Squared reprojection error in sigmas, by the observation's own variance: two terms without a right match, three
/// with. Huge when the point is behind the camera.
[[nodiscard]] double reprojection_chi2(const StereoGeometry& geometry, const Se3& T_cam_body,
                                       const PoseObservation& observation, double sigma_px);

}  // namespace kinetrace::sfm
