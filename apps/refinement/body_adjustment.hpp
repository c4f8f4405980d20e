// Bundle adjustment of one body over many frames: the background or an object.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <vector>

#include <Eigen/Core>

#include "kinetrace/core/bundle.hpp"
#include "kinetrace/core/result.hpp"
#include "kinetrace/refinement/ceres_bundle_adjuster.hpp"

namespace kinetrace::batch {

/// Observation of a body's point in one frame; frames are numbered from 0 in the adjustment.
struct SeenPoint {
  std::uint32_t frame = 0;
  std::uint32_t point_id = 0;
  Eigen::Vector3f px = Eigen::Vector3f::Zero();  ///< u_left, v, u_right; u_right is NaN without a right match.
};

struct RefinedPoint {
  std::uint32_t id = 0;
  std::uint32_t last_frame = 0;
  Eigen::Vector3d position_m = Eigen::Vector3d::Zero();  ///< Body frame.
  double error_px = 0.0;                                 ///< Root mean square over its observations.
  std::uint16_t observations = 0;
};

/// Adjusted states, and constraints beside the observations. Frames without observations follow from the constraints.
struct BodyProblem {
  StereoGeometry geometry;
  std::vector<Se3> T_body_cam;  ///< First estimates; adjusted in place.
  std::vector<SeenPoint> seen;  ///< By frame.
  std::vector<std::uint32_t> fixed_frames;
  std::optional<refinement::BatchMotion> motion;
  std::vector<refinement::BatchPose> measured_poses;
  std::vector<refinement::BatchStep> measured_steps;
};

struct BodyFit {
  std::vector<RefinedPoint> points;  ///< Those with a stereo match, in ascending id.
  double sigma_px = 0.0;             ///< Standard deviation of the observations, from the residuals.
  /// By frame, of the left perturbation of T_cam_body, if requested and with at most
  /// CeresBundleAdjuster::kMaxCovarianceFrames frames.
  std::vector<Matrix6d> covariances;
};

struct AdjustmentOptions {
  int threads = 1;
  bool with_covariances = false;
  std::function<bool()> keep_going = {};
};

/// Initial points are triangulated by stereo from the given poses. Three rounds: the noise of the second is from the
/// median residual of the first, the weight of the third from the autocorrelation of the second's along tracks: so many
/// neighbouring observations of a point count as one beside the priors. Points seen in one frame do not constrain the
/// path; they are triangulated afterwards. Errors: those of CeresBundleAdjuster.
[[nodiscard]] Result<BodyFit> adjust_body(BodyProblem& problem, const AdjustmentOptions& options);

}  // namespace kinetrace::batch
