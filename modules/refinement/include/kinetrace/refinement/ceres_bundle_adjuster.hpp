// Stereo bundle adjustment with Ceres: whole trajectories after a run, and the reference for the online solver.
#pragma once

#include <cstdint>
#include <functional>
#include <limits>
#include <optional>
#include <span>
#include <vector>

#include <Eigen/Core>

#include "kinetrace/core/body_velocity.hpp"
#include "kinetrace/core/bundle.hpp"
#include "kinetrace/core/result.hpp"

namespace kinetrace::refinement {

struct CeresBundleConfig {
  int max_iterations = 50;
  int threads = 1;
  double robust_threshold_sigmas = 2.0;  ///< As in FixedBundleConfig.
  double relative_cost_tolerance = 1e-6;
  std::function<bool()> keep_going = {};  ///< Called after every iteration; false stops with the present state.

  [[nodiscard]] Status validate() const;
};

/// One observation in a batch problem.
struct BatchObservation {
  std::uint32_t point = 0;
  std::uint32_t frame = 0;
  BundleObservation observation;
};

/// Motion model of a body in the world, by frame of the problem.
struct BatchMotion {
  std::span<const Se3> T_world_cam;             ///< One per frame.
  std::span<const std::int64_t> timestamps_ns;  ///< One per frame, ascending.
  /// One per frame; 1: prior that the body has not moved since the frame before, unless its points contradict (Cauchy
  /// loss at one sigma).
  std::span<const std::uint8_t> at_rest;
  MotionPrior prior = {};
  std::optional<Eigen::Vector3d> vertical = std::nullopt;  ///< Normal of the ground, world axes, if known.
  Vector6d rest_velocity = Vector6d::Ones();  ///< Standard deviations of the apparent velocity at rest: rad/s, m/s.
  /// Usual turn rate while moving, rad/s; more as far as the points show it (Cauchy loss at one sigma).
  double turn_rate_radps = std::numeric_limits<double>::infinity();
};

/// An external measurement of the body's pose in the world.
struct BatchPose {
  std::uint32_t frame = 0;
  Se3 T_world_body;
  Vector6d inverse_sigma = Vector6d::Ones();  ///< Of rotation about the world's axes (1/rad) and position (1/m).
};

/// An external measurement of one frame's camera pose relative to another one's.
struct BatchStep {
  std::uint32_t from = 0;
  std::uint32_t to = 0;
  Se3 T_from_to;
  Matrix6d root_information = Matrix6d::Identity();  ///< U with U^T U = inverse covariance of the left perturbation.
};

/// An external position fix of the camera's path on a map. The map has a pose in the body's frame as a camera has:
/// `map` is its entry in T_body_cam. The fix is that of a point of the camera (an antenna), interpolated linearly in
/// time between two frames.
struct BatchFix {
  std::uint32_t map = 0;
  std::uint32_t before = 0;
  std::uint32_t after = 0;
  double part = 0.0;                                        ///< Of the interval from `before` to `after`, [0, 1].
  Eigen::Vector3d antenna_m = Eigen::Vector3d::Zero();      ///< Camera frame.
  Eigen::Vector3d position_m = Eigen::Vector3d::Zero();     ///< On the map.
  Eigen::Vector3d inverse_sigma = Eigen::Vector3d::Zero();  ///< 1/m, along the map's axes.
};

/// Common scale of steps and loops: ratio of the true distances between frames to the measured ones, as caused by a
/// wrong baseline.
struct BatchScale {
  double value = 1.0;
  double sigma = 0.0;  ///< Standard deviation of its prior about 1; 0: fixed to 1.
};

/// A whole trajectory with all its points and any number of frames. Refined in place; nothing is owned.
struct BatchProblem {
  StereoGeometry geometry;
  std::span<Se3> T_body_cam;
  std::span<const std::uint32_t>
      fixed_frames;                     ///< Indices of fixed poses; at least one (gauge), unless poses are measured.
  std::span<Eigen::Vector3d> points_m;  ///< Body frame. Points without observations are unchanged.
  std::span<const BatchObservation> observations;
  std::span<const TurnPrior> turns = {};  ///< As of a BundleWindow.
  std::optional<BatchMotion> motion = {};
  std::span<const BatchPose> measured_poses = {};  ///< Under a Huber loss at three sigmas; need `motion`.
  std::span<const BatchStep> measured_steps = {};
  std::span<const BatchStep> loops = {};  ///< Under a Huber loss at three sigmas, against false loop closures.
  BatchScale scale = {};
  std::span<const BatchFix> fixes = {};  ///< Under a Huber loss at three sigmas.
};

/// Minimises the same cost as FixedBundleAdjuster, in double precision. Allocates; not for online use.
/// Errors as FixedBundleAdjuster, apart from its capacities; kInternal if Ceres fails.
class CeresBundleAdjuster final : public BundleAdjuster {
 public:
  [[nodiscard]] static Result<CeresBundleAdjuster> create(const CeresBundleConfig& config);

  [[nodiscard]] Result<BundleSummary> refine(BundleWindow& window) override;
  /// As `refine` for a whole trajectory; the summary holds no covariance.
  [[nodiscard]] Result<BundleSummary> refine_batch(BatchProblem& problem);
  /// Marginal covariance of each pose at the present state (left perturbation of T_cam_body), robust weights applied,
  /// points and other free poses integrated out; zero for fixed frames. For at most kMaxCovarianceFrames.
  [[nodiscard]] Result<std::vector<Matrix6d>> pose_covariances(BatchProblem& problem) const;
  static constexpr std::size_t kMaxCovarianceFrames = 600;

 private:
  explicit CeresBundleAdjuster(const CeresBundleConfig& config) : config_(config) {}

  CeresBundleConfig config_;
};

}  // namespace kinetrace::refinement
