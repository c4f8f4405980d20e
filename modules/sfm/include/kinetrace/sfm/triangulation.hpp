// Triangulation of a point from all its rays, temporal and stereo (the paper's central point).
#pragma once

#include <cstdint>
#include <optional>
#include <span>

#include <Eigen/Core>

#include "kinetrace/core/bundle.hpp"

namespace kinetrace::sfm {

/// Least-squares intersection of rays in the body frame.
///
/// `seen` selects columns of `row` (one observation per window frame) and of `T_body_cam`. A right match adds the ray
/// of the right view. Empty when the largest angle between two rays is under `min_parallax_rad`, or the point is not in
/// front of all cameras.
[[nodiscard]] std::optional<Eigen::Vector3d> triangulate(const StereoGeometry& geometry,
                                                         std::span<const Se3> T_body_cam,
                                                         std::span<const BundleObservation> row, std::uint32_t seen,
                                                         double min_parallax_rad);

}  // namespace kinetrace::sfm
