#include "kinetrace/evaluation/box_metrics.hpp"

#include <cmath>
#include <numbers>

namespace kinetrace::evaluation {
namespace {

constexpr double kDegPerRad = 180.0 / std::numbers::pi;

}  // namespace

BoxErrors& BoxMetrics::cell(bool moving, double distance_m, BoxStage stage) noexcept {
  std::size_t distance = 0;
  while (distance < kBoxDistances_m.size() && distance_m > kBoxDistances_m[distance]) {
    ++distance;
  }
  return cells[moving ? 1 : 0][distance][static_cast<std::size_t>(stage)];
}

void compare(const OrientedBox& truth, const Box3& estimate, const Box3Sigma& sigma, BoxErrors& errors) {
  const OrientedBox box{{estimate.rotation(), estimate.center_m}, estimate.size_m};
  const BoxOverlap overlapping = overlap(truth, box);
  errors.iou_3d.add(overlapping.iou_3d);
  errors.iou_footprint.add(overlapping.iou_footprint);
  const Eigen::Vector3d center_m =
      box.T_world_box.rotation.transpose() * (estimate.center_m - truth.T_world_box.translation);
  const Eigen::Vector3d size_m = estimate.size_m - truth.size_m;
  errors.center_m.add(center_m.norm());
  for (int i = 0; i < 3; ++i) {
    errors.size_m[static_cast<std::size_t>(i)].add(std::abs(size_m[i]));
    errors.center_normalised.add(center_m[i], sigma.center_m[i]);
    errors.size_normalised.add(size_m[i], sigma.size_m[i]);
  }
  const Eigen::Vector3d along = truth.T_world_box.rotation.transpose() * box.T_world_box.rotation.col(0);
  const double off_rad = std::remainder(std::atan2(-along.z(), along.x()), std::numbers::pi);
  errors.yaw_deg.add(std::abs(off_rad) * kDegPerRad);
  errors.yaw_normalised.add(off_rad, sigma.yaw_rad);
  if (sigma.heading_known) {
    ++errors.known_headings;
    errors.known_turned += along.x() < 0.0 ? 1 : 0;
  }
}

}  // namespace kinetrace::evaluation
