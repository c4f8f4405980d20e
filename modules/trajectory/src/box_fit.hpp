// The most probable box of an object, given some views of it.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>

#include <Eigen/Core>

#include "kinetrace/core/se3.hpp"
#include "kinetrace/core/stereo_geometry.hpp"
#include "kinetrace/trajectory/box_view.hpp"
#include "kinetrace/trajectory/ground_plane.hpp"
#include "kinetrace/trajectory/size_table.hpp"

namespace kinetrace::trajectory {

using Vector7d = Eigen::Matrix<double, 7, 1>;
using Matrix7d = Eigen::Matrix<double, 7, 7>;

/// All evidence of a box. Ground and heading are in the object's frame.
struct BoxEvidence {
  const StereoGeometry& geometry;
  std::span<const BoxView> views;
  Eigen::Vector3d down = Eigen::Vector3d::UnitY();
  Ground ground;
  std::optional<Heading> heading;
  std::span<const KindOfObject> kinds;
};

struct BoxFit {
  BoxState state;
  double cost = 0.0;                           ///< Twice the negative log-likelihood, up to a constant.
  double misfit = 1.0;                         ///< Residual variance over that of a body that fits, at least 1.
  Matrix7d covariance = Matrix7d::Identity();  ///< Of centre (object frame), yaw, size; scaled by the misfit.
};

/// Gauss-Newton from `start`, robust, `iterations` times.
[[nodiscard]] BoxFit fit_box(const BoxEvidence& evidence, const BoxState& start, int iterations) noexcept;

}  // namespace kinetrace::trajectory
