#include "scene_evidence.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>

#include <Eigen/Cholesky>

namespace kinetrace::self_calibration {
namespace {

double quantile(std::vector<double>& values, double part) {
  if (values.empty()) {
    return 0.0;
  }
  const auto place = values.begin() + static_cast<std::ptrdiff_t>(part * static_cast<double>(values.size() - 1));
  std::nth_element(values.begin(), place, values.end());
  return *place;
}

const Observation& last_left(const BundlePoint& point) {
  return *std::find_if(point.observations.rbegin(), point.observations.rend(),
                       [](const Observation& seen) { return seen.view == 0; });
}

/// Distance of the observation from the projection of the same point at infinity.
double parallax_px(const RigModel& rig, const BundleWindow& window, const BundlePoint& point) {
  BundlePoint far = point;
  far.ray_and_inverse_depth[2] = 0.0;
  const Observation& seen = last_left(point);
  return (residual_px(rig, window, point, seen) - residual_px(rig, window, far, seen)).norm();
}

/// Inverse depths of a plane are linear in the image: least absolute values by iterated weights.
double plane_share(const RigModel& rig, const BundleWindow& window) {
  constexpr double kNear_px = 0.3;  // Of disparity.
  constexpr double kFloor_px = 0.05;
  std::vector<Eigen::Vector4d> points;  // x, y, 1, disparity.
  for (const BundlePoint& point : window.points) {
    const auto& [x, y, w] = point.ray_and_inverse_depth;
    if (point.used && point.observations.front().frame == 0) {
      points.emplace_back(x, y, 1.0, w * rig.baseline_m * rig.focal_px(0));
    }
  }
  if (points.size() < 10) {
    return 0.0;
  }
  Eigen::Vector3d plane = Eigen::Vector3d::Zero();
  for (int i = 0; i < 30; ++i) {
    Eigen::Matrix3d normal = 1e-9 * Eigen::Matrix3d::Identity();
    Eigen::Vector3d right = Eigen::Vector3d::Zero();
    for (const Eigen::Vector4d& p : points) {
      const double weight = 1.0 / std::max(std::abs(p[3] - plane.dot(p.head<3>())), kFloor_px);
      normal += weight * p.head<3>() * p.head<3>().transpose();
      right += weight * p[3] * p.head<3>();
    }
    plane = normal.ldlt().solve(right);
  }
  const auto near = std::count_if(points.begin(), points.end(), [&](const Eigen::Vector4d& p) {
    return std::abs(p[3] - plane.dot(p.head<3>())) < kNear_px;
  });
  return static_cast<double>(near) / static_cast<double>(points.size());
}

}  // namespace

SceneEvidence scene_evidence(const RigModel& rig, const std::vector<BundleWindow>& windows) {
  SceneEvidence evidence;
  std::vector<double> travels;
  std::vector<double> parallaxes;
  std::vector<double> depths;
  for (const BundleWindow& window : windows) {
    for (const BundlePoint& point : window.points) {
      if (point.used) {
        travels.push_back((last_left(point).raw_px - point.observations.front().raw_px).norm());
        parallaxes.push_back(parallax_px(rig, window, point));
        depths.push_back(1.0 / point.ray_and_inverse_depth[2]);
      }
    }
    evidence.plane_share += plane_share(rig, window) / static_cast<double>(windows.size());
  }
  evidence.points = depths.size();
  evidence.travel_px = quantile(travels, 0.5);
  evidence.parallax_px = quantile(parallaxes, 0.5);
  evidence.depth_ratio = depths.empty() ? 1.0 : quantile(depths, 0.9) / quantile(depths, 0.1);
  return evidence;
}

}  // namespace kinetrace::self_calibration
