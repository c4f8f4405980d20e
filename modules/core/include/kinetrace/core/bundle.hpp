// The window that bundle adjustment works on: poses x points with a table of stereo observations.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include <Eigen/Core>

#include "kinetrace/core/export.hpp"
#include "kinetrace/core/result.hpp"
#include "kinetrace/core/se3.hpp"
#include "kinetrace/core/stereo_geometry.hpp"

namespace kinetrace {

inline constexpr int kMaxWindowFrames = 32;  ///< Frames of a window fit one bit mask.

/// One observation: v is the mean row of the pair; u_right is NaN where only the left view saw the point.
struct BundleObservation {
  float u_left_px = 0.F;
  float v_px = 0.F;
  float u_right_px = kNoRight;
  float inverse_sigma_px = 1.F;  ///< One over the standard deviation of the measurement.
};

/// A point with the window frames that see it: bit k of `frames` set = observation in column k.
struct BundlePoint {
  Eigen::Vector3d position_m = Eigen::Vector3d::Zero();  ///< Body frame.
  std::uint32_t frames = 0;
};

/// Prior on a body in a window frame: it has not rotated in the world since the frame before, up to a standard
/// deviation.
struct TurnPrior {
  /// Rotates directions from this frame's camera to the camera of the frame before, by their attitudes in the world.
  Eigen::Matrix3d R_before_now = Eigen::Matrix3d::Identity();
  double inverse_sigma_rad = 0.0;  ///< One over the standard deviation of the body's turn; 0: no prior.
};

/// A window to be refined in place. Nothing is owned.
struct BundleWindow {
  StereoGeometry geometry;
  std::span<Se3> T_body_cam;       ///< One per window frame, at most kMaxWindowFrames.
  std::uint32_t fixed_frames = 0;  ///< Bit k set: pose k is not changed. At least one must be set (gauge).
  std::span<BundlePoint> points;   ///< Points with frames == 0 are ignored.
  std::span<const BundleObservation> observations;  ///< Row-major: observations[point * T_body_cam.size() + frame].
  /// One per window frame, the first without effect; empty: no prior.
  std::span<const TurnPrior> turns = {};

  [[nodiscard]] const BundleObservation& observation(std::size_t point, std::size_t frame) const noexcept {
    return observations[point * T_body_cam.size() + frame];
  }
};

/// Result of a refinement.
struct BundleSummary {
  int iterations = 0;
  double initial_cost = 0.0;  ///< Sum over observations and turns of the robust loss / 2, in units of sigma^2.
  double final_cost = 0.0;
  bool converged = false;
  Matrix6d newest_covariance = Matrix6d::Zero();  ///< Marginal covariance of the last pose (left perturbation of
                                                  ///< T_body_cam), points and poses integrated out.
};

/// Stereo bundle adjustment behind one interface: the fixed-size online solver and the Ceres batch solver.
class KINETRACE_API BundleAdjuster {
 public:
  BundleAdjuster() = default;
  BundleAdjuster(const BundleAdjuster&) = delete;
  BundleAdjuster& operator=(const BundleAdjuster&) = delete;
  BundleAdjuster(BundleAdjuster&&) = default;
  BundleAdjuster& operator=(BundleAdjuster&&) = default;
  virtual ~BundleAdjuster() = default;

  /// Minimises the robust stereo reprojection error over free poses and all points, in place. A window without free
  /// parameters or observations is left as it is. Errors: kCapacity if the window exceeds the solver's size.
  [[nodiscard]] virtual Result<BundleSummary> refine(BundleWindow& window) = 0;
};

}  // namespace kinetrace
