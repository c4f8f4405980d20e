// Stereo bundle adjustment with Ceres: whole trajectories after a run, and the oracle for the online solver.
#pragma once

#include <cstdint>
#include <span>

#include <Eigen/Core>

#include "kinetrace/core/bundle.hpp"
#include "kinetrace/core/result.hpp"

namespace kinetrace::refinement {

struct CeresBundleConfig {
  int max_iterations = 50;
  int threads = 1;
  double robust_threshold_sigmas = 2.0;  ///< As in FixedBundleConfig.
  double relative_cost_tolerance = 1e-6;

  [[nodiscard]] Status validate() const;
};

/// One observation in a batch problem.
struct BatchObservation {
  std::uint32_t point = 0;
  std::uint32_t frame = 0;
  BundleObservation observation;
};

/// A whole trajectory with all its points, without a limit on frames. Refined in place; nothing is owned.
struct BatchProblem {
  StereoGeometry geometry;
  std::span<Se3> T_body_cam;
  std::span<const std::uint32_t> fixed_frames;  ///< Indices of poses that are not changed; at least one (gauge).
  std::span<Eigen::Vector3d> points_m;          ///< Body frame. Points without observations are left as they are.
  std::span<const BatchObservation> observations;
  std::span<const TurnPrior> turns = {};  ///< As of a BundleWindow.
};

/// Minimises the very cost of FixedBundleAdjuster in double precision. Allocates; not for use on line.
/// Errors as FixedBundleAdjuster, apart from its capacities; kInternal if Ceres fails.
class CeresBundleAdjuster final : public BundleAdjuster {
 public:
  [[nodiscard]] static Result<CeresBundleAdjuster> create(const CeresBundleConfig& config);

  [[nodiscard]] Result<BundleSummary> refine(BundleWindow& window) override;
  /// As `refine` for a whole trajectory; the summary holds no covariance.
  [[nodiscard]] Result<BundleSummary> refine_batch(BatchProblem& problem);

 private:
  explicit CeresBundleAdjuster(const CeresBundleConfig& config) : config_(config) {}

  CeresBundleConfig config_;
};

}  // namespace kinetrace::refinement
