// What measuring again has changed in a frame's disparities.
#pragma once

#include <span>

#include <Eigen/Core>

#include "kinetrace/core/stereo_geometry.hpp"
#include "kinetrace/recording/observations.hpp"

namespace kinetrace::batch {

/// Of a right camera that the run only came to know later: turned about an axis across the baseline (a constant), or
/// about its own (growing over the image). Zero where nothing has surely changed.
class DisparityChange {
 public:
  DisparityChange() = default;

  /// From the background's points, as the run had them and as they are now, in the same order: least squares with
  /// Huber's weights, and zero where the change is no larger than its uncertainty and what two ways of matching differ
  /// by.
  [[nodiscard]] static DisparityChange between(const StereoGeometry& geometry,
                                               std::span<const recording::Observation> before,
                                               std::span<const recording::Observation> now);

  /// Pixels, at a place in the left image.
  [[nodiscard]] double at(const StereoGeometry& geometry, double u_px, double v_px) const noexcept;
  [[nodiscard]] bool is_zero() const noexcept { return change_px_.isZero(0.0); }

 private:
  Eigen::Vector3d change_px_ =
      Eigen::Vector3d::Zero();  ///< In the middle, and for each focal length to the right and down.
};

}  // namespace kinetrace::batch
