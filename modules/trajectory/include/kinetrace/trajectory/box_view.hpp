// What a frame shows of an object's extent, and the box sought.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>

#include <Eigen/Core>

#include "kinetrace/core/se3.hpp"

namespace kinetrace::trajectory {

/// Directions in the left image in which the extent of a mask is measured: columns, rows, both diagonals. A box that is
/// turned has the same extent along columns and rows, and another one along the diagonals.
inline constexpr std::array<std::array<double, 2>, 4> kMaskDirections{
    {{1.0, 0.0}, {0.0, 1.0}, {0.70710678, 0.70710678}, {0.70710678, -0.70710678}}};
inline constexpr std::size_t kMaskSides = 2 * kMaskDirections.size();

/// Edges of a mask in the left image, pixels: the lowest and the highest along each of kMaskDirections.
struct MaskEdges {
  static constexpr double kUnknown = std::numeric_limits<double>::infinity();

  std::array<double, kMaskSides> at_px{};
  /// How far the object may reach beyond what is seen of it, standard deviation: infinite where the image's border cuts
  /// it, or nothing is known.
  std::array<double, kMaskSides> beyond_px{0.0, 0.0, 0.0, 0.0, kUnknown, kUnknown, kUnknown, kUnknown};
};

/// What one frame shows of an object, in the object's frame.
struct BoxView {
  static constexpr std::size_t kMaxPoints = 24;

  Se3 T_obj_cam;
  MaskEdges edges;
  std::array<Eigen::Vector3f, kMaxPoints> points_m;
  std::size_t point_count = 0;
  double depth_sigma_m = 0.0;  ///< Of the points.
  double quality = 0.0;        ///< 0: no view.
  std::int64_t timestamp_ns = 0;
};

/// A box in the object's frame.
struct BoxState {
  Eigen::Vector3d center_m = Eigen::Vector3d::Zero();
  double yaw_rad = 0.0;
  Eigen::Vector3d size_m = Eigen::Vector3d::Ones();  ///< Length, height, width.
};

struct Heading {
  double yaw_rad = 0.0;
  double sigma_rad = 0.0;
};

}  // namespace kinetrace::trajectory
