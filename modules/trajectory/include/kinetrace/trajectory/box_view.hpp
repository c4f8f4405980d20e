// Evidence of one frame for an object's extent, and the box to be estimated.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include <Eigen/Core>

#include "kinetrace/core/se3.hpp"

namespace kinetrace::trajectory {

/// Edges of a mask in the left image, pixels: lowest and highest u, lowest and highest v.
struct MaskEdges {
  std::array<double, 4> at_px{};
  /// Standard deviation of the object's extent beyond each edge; infinite where the image border truncates it.
  std::array<double, 4> beyond_sigma_px{};
};

/// Evidence of one frame, in the object's frame.
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
