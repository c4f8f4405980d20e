#include "kinetrace/evaluation/box_overlap.hpp"

#include <algorithm>
#include <array>
#include <cstddef>
#include <vector>

namespace kinetrace::evaluation {
namespace {

/// Where normal.dot(p) <= offset_m; the normal points outwards and is of unit length.
struct HalfSpace {
  Eigen::Vector3d normal;
  double offset_m = 0.0;
};
using Polygon = std::vector<Eigen::Vector3d>;

void add_half_spaces(const OrientedBox& box, std::vector<HalfSpace>& half_spaces) {
  for (int axis = 0; axis < 3; ++axis) {
    for (const double side : {-1.0, 1.0}) {
      const Eigen::Vector3d normal = side * box.T_world_box.rotation.col(axis);
      half_spaces.push_back({normal, normal.dot(box.T_world_box.translation) + 0.5 * box.size_m[axis]});
    }
  }
}

/// Sutherland and Hodgman 1974.
Polygon clipped(const Polygon& polygon, const HalfSpace& half_space) {
  Polygon kept;
  for (std::size_t i = 0; i < polygon.size(); ++i) {
    const Eigen::Vector3d& a = polygon[i];
    const Eigen::Vector3d& b = polygon[(i + 1) % polygon.size()];
    const double beyond_a = half_space.normal.dot(a) - half_space.offset_m;
    const double beyond_b = half_space.normal.dot(b) - half_space.offset_m;
    if (beyond_a <= 0.0) {
      kept.push_back(a);
    }
    if ((beyond_a <= 0.0) != (beyond_b <= 0.0)) {
      kept.push_back(a + beyond_a / (beyond_a - beyond_b) * (b - a));
    }
  }
  return kept;
}

double area_of(const Polygon& polygon) {
  Eigen::Vector3d doubled = Eigen::Vector3d::Zero();
  for (std::size_t i = 2; i < polygon.size(); ++i) {
    doubled += (polygon[i - 1] - polygon[0]).cross(polygon[i] - polygon[0]);
  }
  return 0.5 * doubled.norm();
}

/// A square in the plane, much larger than the polygon it is clipped to.
Polygon square_of(const HalfSpace& plane, const Eigen::Vector3d& near_m, double half_m) {
  const Eigen::Vector3d middle = near_m + (plane.offset_m - plane.normal.dot(near_m)) * plane.normal;
  const Eigen::Vector3d u = half_m * plane.normal.unitOrthogonal();
  const Eigen::Vector3d v = plane.normal.cross(u);
  return {middle + u + v, middle - u + v, middle - u - v, middle + u - v};
}

/// Volume of the half spaces' intersection, by the divergence theorem: a third of the sum of its faces' areas times
/// their distances from `inside_m`.
double common_volume(const std::vector<HalfSpace>& half_spaces, const Eigen::Vector3d& inside_m, double reach_m) {
  constexpr double kSamePlane = 1e-9;
  double volume = 0.0;
  for (std::size_t i = 0; i < half_spaces.size(); ++i) {
    Polygon face = square_of(half_spaces[i], inside_m, reach_m);
    for (std::size_t j = 0; j < half_spaces.size() && !face.empty(); ++j) {
      const bool is_same = (half_spaces[i].normal - half_spaces[j].normal).norm() < kSamePlane &&
                           std::abs(half_spaces[i].offset_m - half_spaces[j].offset_m) < kSamePlane;
      if (is_same && j < i) {
        face.clear();  // Counted with an identical plane.
      } else if (!is_same) {
        face = clipped(face, half_spaces[j]);
      }
    }
    volume += area_of(face) * (half_spaces[i].offset_m - half_spaces[i].normal.dot(inside_m)) / 3.0;
  }
  return std::max(volume, 0.0);
}

double intersection_volume(const OrientedBox& a, const OrientedBox& b) {
  std::vector<HalfSpace> half_spaces;
  add_half_spaces(a, half_spaces);
  add_half_spaces(b, half_spaces);
  return common_volume(half_spaces, a.T_world_box.translation, 2.0 * (a.size_m.norm() + b.size_m.norm()));
}

double ratio(double common, double first, double second) {
  return std::clamp(common / (first + second - common), 0.0, 1.0);
}

/// The same box turned upright about the y axis of `truth`, a metre high and at the same height.
OrientedBox footprint(const OrientedBox& box, const OrientedBox& truth) {
  const Eigen::Matrix3d R_truth_box = truth.T_world_box.rotation.transpose() * box.T_world_box.rotation;
  const double yaw_rad = std::atan2(-R_truth_box(2, 0), R_truth_box(0, 0));
  Eigen::Vector3d middle = truth.T_world_box.inverse() * box.T_world_box.translation;
  middle.y() = 0.0;
  return {{so3_exp({0.0, yaw_rad, 0.0}), middle}, {box.size_m.x(), 1.0, box.size_m.z()}};
}

}  // namespace

BoxOverlap overlap(const OrientedBox& truth, const OrientedBox& estimate) {
  if (truth.size_m.minCoeff() <= 0.0 || estimate.size_m.minCoeff() <= 0.0) {
    return {};
  }
  const OrientedBox true_footprint = footprint(truth, truth);
  const OrientedBox estimated_footprint = footprint(estimate, truth);
  return {.iou_3d = ratio(intersection_volume(truth, estimate), truth.size_m.prod(), estimate.size_m.prod()),
          .iou_footprint = ratio(intersection_volume(true_footprint, estimated_footprint), true_footprint.size_m.prod(),
                                 estimated_footprint.size_m.prod())};
}

}  // namespace kinetrace::evaluation
