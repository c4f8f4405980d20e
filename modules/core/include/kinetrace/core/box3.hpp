// An upright 3-D box and its uncertainty.
#pragma once

#include <array>
#include <cstddef>

#include <Eigen/Core>

#include "kinetrace/core/export.hpp"

namespace kinetrace {

/// Axes of an upright box as columns: x along its length, y down, z across. The box is rotated by `yaw_rad` about +y,
/// then by the smallest rotation that takes +y to `down` (unit length).
[[nodiscard]] KINETRACE_API Eigen::Matrix3d upright_axes(const Eigen::Vector3d& down, double yaw_rad);

/// The yaw of a direction in the plane normal to `down`; see upright_axes.
[[nodiscard]] KINETRACE_API double upright_yaw(const Eigen::Vector3d& down, const Eigen::Vector3d& direction);

/// Oriented box, world frame. It stands on the ground: `down` is that of the ground below it where known, else the
/// world's y axis.
struct Box3 {
  Eigen::Vector3d center_m = Eigen::Vector3d::Zero();
  Eigen::Vector3d size_m = Eigen::Vector3d::Zero();  ///< Length (along the heading), height, width.
  double yaw_rad = 0.0;  ///< Rotation about `down` (KITTI rotation_y): 0 = length along +x, pi/2 = length along -z.
  Eigen::Vector3d down = Eigen::Vector3d::UnitY();

  /// R_world_box: length, down, across.
  [[nodiscard]] Eigen::Matrix3d rotation() const { return upright_axes(down, yaw_rad); }
  [[nodiscard]] std::array<Eigen::Vector3d, 8> corners() const {
    const Eigen::Matrix3d edges = rotation() * (0.5 * size_m).asDiagonal();
    std::array<Eigen::Vector3d, 8> result;
    for (std::size_t i = 0; i < result.size(); ++i) {
      result[i] = center_m + edges * Eigen::Vector3d((i & 1U) != 0U ? 1.0 : -1.0, (i & 2U) != 0U ? 1.0 : -1.0,
                                                     (i & 4U) != 0U ? 1.0 : -1.0);
    }
    return result;
  }
};

/// Standard deviations of a box. Extents on a side that was never observed have those of the object's class.
struct Box3Sigma {
  Eigen::Vector3d center_m = Eigen::Vector3d::Zero();  ///< Along the length, down, across.
  Eigen::Vector3d size_m = Eigen::Vector3d::Zero();
  double yaw_rad = 0.0;  ///< Modulo 180 degrees, see heading_known.
  /// True if the motion has shown which end is the front. Otherwise the yaw may be off by 180 degrees.
  bool heading_known = false;
};

}  // namespace kinetrace
