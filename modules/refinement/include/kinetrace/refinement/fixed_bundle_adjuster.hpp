// Online stereo bundle adjustment with a fixed memory footprint.
#pragma once

#include <algorithm>
#include <cstddef>

#include "kinetrace/core/arena.hpp"
#include "kinetrace/core/bundle.hpp"
#include "kinetrace/core/export.hpp"
#include "kinetrace/core/result.hpp"

namespace kinetrace::refinement {

struct KINETRACE_API FixedBundleConfig {
  int max_frames = 12;     ///< Poses of a window, at most kMaxWindowFrames.
  int max_points = 600;    ///< Points of a window that are seen by at least one frame.
  int max_iterations = 6;  ///< Damped steps tried, accepted or not.
  /// Threshold of the Cauchy loss on the norm of an observation's two or three rows: there, its weight is one half.
  double robust_threshold_sigmas = 2.0;
  double initial_damping = 1e-4;          ///< Levenberg-Marquardt damping relative to the Hessian's diagonal.
  double relative_cost_tolerance = 1e-3;  ///< Converged when a step changes the cost by less than this fraction.

  [[nodiscard]] Status validate() const;
};

struct FixedBundleStorage;

/// Levenberg-Marquardt with the Schur complement over the points (Triggs et al., "Bundle adjustment - a modern
/// synthesis", 1999), in single precision eight points at a time; poses, the reduced camera system and the cost are
/// kept in double precision. Works in the frame of the oldest fixed camera, so the body frame may be anywhere.
///
/// A point moves at most half its depth per step, so that a single far point cannot block convergence. An observation
/// behind its camera has a large constant cost and no derivatives. A window whose poses are all fixed is unchanged.
///
/// Priors on the body's rotation have a Cauchy loss of their own, with a threshold of one sigma.
///
/// Errors of `refine`: kCapacity, the window exceeds max_frames or max_points; kInvalidArgument, no fixed pose, an
/// observation table too small, turns for other frames, or a value that is not finite; kBadCalibration. The window is
/// then unchanged. Without an error `refine` allocates nothing.
class KINETRACE_API FixedBundleAdjuster final : public BundleAdjuster {
 public:
  [[nodiscard]] static Result<FixedBundleAdjuster> create(const FixedBundleConfig& config, Arena& arena);
  [[nodiscard]] static std::size_t required_bytes(const FixedBundleConfig& config);

  [[nodiscard]] Result<BundleSummary> refine(BundleWindow& window) override;

  /// Limits the iterations from now on, to 1 or more; never above the configured number.
  void limit(int max_iterations) noexcept { config_.max_iterations = std::min(configured_iterations_, max_iterations); }

 private:
  FixedBundleAdjuster(const FixedBundleConfig& config, FixedBundleStorage& storage)
      : config_(config), configured_iterations_(config.max_iterations), storage_(&storage) {}

  FixedBundleConfig config_;
  int configured_iterations_;
  FixedBundleStorage* storage_;  ///< In the arena.
};

}  // namespace kinetrace::refinement
