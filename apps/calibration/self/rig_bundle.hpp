// Bundle adjustment in which the rig itself is unknown: windows of frames share two lenses and a mount.
#pragma once

#include <array>
#include <cstddef>
#include <span>
#include <vector>

#include <Eigen/Core>

#include "kinetrace/core/result.hpp"
#include "kinetrace/core/se3.hpp"
#include "rig_model.hpp"
#include "track_window.hpp"

namespace kinetrace::self_calibration {

using PoseBlock = std::array<double, 6>;  ///< T_camera_world: rotation vector, translation; metres.

/// A point as (x, y, 1) / inverse depth in a host frame, which keeps its initial pose: far and near points are equally
/// well conditioned (Civera et al., T-RO 2008), with at most three parameters.
struct BundlePoint {
  Se3 T_host_world;
  std::array<double, 3> ray_and_inverse_depth{};
  std::vector<Observation> observations;
  double sigma_scale = 1.0;  ///< Noise of its observations relative to the usual: larger for points of low contrast.
  bool used = true;
};

struct BundleWindow {
  std::vector<PoseBlock> poses;  ///< Of the left camera; the first is fixed.
  std::vector<BundlePoint> points;
};

/// Standard deviations of usual lenses; weak compared to the images.
struct LensPriors {
  LensBlock sigma{0.5, 0.004, 0.03, 0.03, 0.5, 0.4, 0.003, 0.003, 0.15};
  /// Between the two lenses of a rig, which are of one kind.
  LensBlock sigma_between{0.01, 0.003, 0.03, 0.03, 0.03, 0.06, 0.003, 0.003, 0.06};
  double sigma_mount = 0.1;
};

struct BundleOptions {
  LensPriors priors;
  double sigma_px = 0.3;       ///< Of an average observation.
  double robust_sigmas = 2.0;  ///< Scale of the Cauchy loss.
  bool rig_fixed = false;      ///< Poses and points alone.
  int iterations = 30;
  double tolerance = 1e-6;  ///< Relative change of the cost for convergence.
  int threads = 1;
};

struct BundleResult {
  double cost = 0.0;
  int iterations = 0;
  bool converged = false;
};

/// Improves rig, poses and points together. Errors: kInternal where Ceres fails.
[[nodiscard]] Result<BundleResult> adjust(RigModel& rig, std::span<BundleWindow> windows, const BundleOptions& options);

/// Residual of one observation in pixels.
[[nodiscard]] Eigen::Vector2d residual_px(const RigModel& rig, const BundleWindow& window, const BundlePoint& point,
                                          const Observation& seen);

/// Normal equations of one window for the rig alone, with poses and points eliminated.
struct RigInformation {
  Eigen::Matrix<double, kRigSize, kRigSize> normal = Eigen::Matrix<double, kRigSize, kRigSize>::Zero();
  Eigen::Matrix<double, kRigSize, 1> gradient = Eigen::Matrix<double, kRigSize, 1>::Zero();
};
/// Parameters in the order left lens, right lens, mount.
[[nodiscard]] RigInformation rig_information(const RigModel& rig, const BundleWindow& window,
                                             const BundleOptions& options);
/// The same of the priors.
[[nodiscard]] RigInformation prior_information(const RigModel& rig, const LensPriors& priors);

}  // namespace kinetrace::self_calibration
