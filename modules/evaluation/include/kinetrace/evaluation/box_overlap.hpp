// Intersection over union of oriented boxes.
#pragma once

#include <Eigen/Core>

#include "kinetrace/core/se3.hpp"

namespace kinetrace::evaluation {

struct OrientedBox {
  Se3 T_world_box;                                   ///< Origin in the middle.
  Eigen::Vector3d size_m = Eigen::Vector3d::Zero();  ///< Along the box's own axes.
};

struct BoxOverlap {
  double iou_3d = 0.0;         ///< Of the volumes.
  double iou_footprint = 0.0;  ///< Of the footprints in the plane that the true box's y axis is normal to.
};

/// For two boxes upright about the same axis as in KITTI's benchmark: intersection of footprints times common height.
/// Exact also for boxes tilted against each other. Zero where a box has no volume.
[[nodiscard]] BoxOverlap overlap(const OrientedBox& truth, const OrientedBox& estimate);

}  // namespace kinetrace::evaluation
