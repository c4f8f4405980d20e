// Change of a frame's disparities by measuring again.
#pragma once

#include <span>

#include <Eigen/Core>

#include "kinetrace/core/stereo_geometry.hpp"
#include "kinetrace/recording/observations.hpp"

namespace kinetrace::batch {

/// Caused by a right camera whose pose the run learnt only later: turned about an axis across the baseline (a
/// constant), or about the baseline (growing over the image). Zero without a significant change.
class DisparityChange {
 public:
  DisparityChange() = default;

  /// From the background's points, of the run and as measured again, in the same order: least squares with Huber's
  /// weights. Zero if the change does not exceed its uncertainty and the difference between the two matching methods.
  [[nodiscard]] static DisparityChange between(const StereoGeometry& geometry,
                                               std::span<const recording::Observation> before,
                                               std::span<const recording::Observation> now);

  /// In pixels, at a position in the left image.
  [[nodiscard]] double at(const StereoGeometry& geometry, double u_px, double v_px) const noexcept;
  [[nodiscard]] bool is_zero() const noexcept { return change_px_.isZero(0.0); }

 private:
  Eigen::Vector3d change_px_ =
      Eigen::Vector3d::Zero();  ///< At the principal point, and per focal length to the right and down.
};

}  // namespace kinetrace::batch
