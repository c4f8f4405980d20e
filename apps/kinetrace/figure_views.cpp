#include "figure_views.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace kinetrace::figure {

std::array<Eigen::Vector3d, 8> corners_of(const Box3& box) {
  const Eigen::Vector3d along(std::cos(box.yaw_rad), 0.0, -std::sin(box.yaw_rad));
  const Eigen::Vector3d across = Eigen::Vector3d::UnitY().cross(along);
  const Eigen::Vector3d half = box.size_m / 2.0;
  std::array<Eigen::Vector3d, 8> corners;
  std::size_t next = 0;
  for (const double y : {1.0, -1.0}) {
    for (const auto& [x, z] : {std::pair{1.0, 1.0}, {1.0, -1.0}, {-1.0, -1.0}, {-1.0, 1.0}}) {
      corners[next++] =
          box.center_m + along * (x * half.x()) + across * (z * half.z()) + Eigen::Vector3d(0.0, y * half.y(), 0.0);
    }
  }
  return corners;
}

std::vector<Line3> edges_of(const Box3& box) {
  const auto corners = corners_of(box);
  std::vector<Line3> edges;
  for (const std::size_t face : {std::size_t{0}, std::size_t{4}}) {
    for (std::size_t i = 0; i < 4; ++i) {
      edges.push_back({corners[face + i], corners[face + (i + 1) % 4]});
    }
  }
  for (std::size_t i = 0; i < 4; ++i) {
    edges.push_back({corners[i], corners[i + 4]});
  }
  return edges;
}

std::vector<Line2> project_lines(const std::vector<Line3>& lines_cam, const StereoGeometry& geometry,
                                 const ImagePlace& place) {
  std::vector<Line2> images;
  for (const Line3& line : lines_cam) {
    for (std::size_t i = 1; i < line.size(); ++i) {
      Eigen::Vector3d a = line[i - 1];
      Eigen::Vector3d b = line[i];
      if (!a.allFinite() || !b.allFinite() || std::max(a.z(), b.z()) < kNearest_m) {
        continue;
      }
      // The end behind the camera moves to the nearest plane.
      for (auto [near, far] : {std::pair{&a, &b}, std::pair{&b, &a}}) {
        if (near->z() < kNearest_m) {
          *near += (*far - *near) * ((kNearest_m - near->z()) / (far->z() - near->z()));
        }
      }
      const Eigen::Vector3d from = geometry.project(a);
      const Eigen::Vector3d to = geometry.project(b);
      images.push_back({place.to_canvas(from.x(), from.y()), place.to_canvas(to.x(), to.y())});
    }
  }
  return images;
}

Onlooker::Onlooker(const Direction& direction, std::span<const Eigen::Vector3d> seen, double share,
                   const drawing::Rect& area) {
  const Eigen::Vector3d down = direction.down.normalized();
  Eigen::Vector3d level = direction.forward - down * down.dot(direction.forward);
  if (level.norm() < 1e-6) {
    level = down.unitOrthogonal();
  }
  // Walking round to the left turns the view to the right; rising tilts it down.
  const Eigen::Vector3d turned = Eigen::AngleAxisd(direction.aside_rad, down) * level.normalized();
  const Eigen::Vector3d forward = std::cos(direction.elevated_rad) * turned + std::sin(direction.elevated_rad) * down;
  const Eigen::Vector3d right = down.cross(forward).normalized();
  R_eye_.row(0) = right;
  R_eye_.row(1) = forward.cross(right);
  R_eye_.row(2) = forward;

  std::array<std::vector<double>, 3> values;
  for (const Eigen::Vector3d& p : seen) {
    for (Eigen::Index axis = 0; axis < 3; ++axis) {
      values[static_cast<std::size_t>(axis)].push_back(R_eye_.row(axis).dot(p));
    }
  }
  Eigen::Vector3d middle = Eigen::Vector3d::Zero();
  Eigen::Vector3d size = Eigen::Vector3d::Ones();
  for (Eigen::Index axis = 0; axis < 3; ++axis) {
    if (const auto range = drawing::quantile_range(values[static_cast<std::size_t>(axis)], share)) {
      middle[axis] = range->center();
      size[axis] = std::max(range->size(), 0.05);
    }
  }
  // Far enough that the nearest things are about twice as large as the farthest.
  middle_distance_m_ = 0.5 * size.norm() + 1.0 * size.z();
  eye_ = R_eye_.transpose() * (middle - Eigen::Vector3d(0.0, 0.0, middle_distance_m_));

  std::vector<double> u;
  std::vector<double> v;
  for (const Eigen::Vector3d& p : seen) {
    const Eigen::Vector3d q = R_eye_ * (p - eye_);
    if (q.z() > 0.05 * middle_distance_m_) {
      u.push_back(q.x() / q.z());
      v.push_back(q.y() / q.z());
    }
  }
  const drawing::Range fallback{-0.5, 0.5};
  const drawing::Range x = drawing::quantile_range(u, share).value_or(fallback).at_least(1e-3).widened(0.05);
  const drawing::Range y = drawing::quantile_range(v, share).value_or(fallback).at_least(1e-3).widened(0.05);
  scale_ = std::min(area.width / x.size(), area.height / y.size());
  origin_ = area.center() - scale_ * drawing::Point(x.center(), y.center());
}

drawing::Point Onlooker::to_canvas(const Eigen::Vector3d& p) const {
  const Eigen::Vector3d q = R_eye_ * (p - eye_);
  if (!(q.z() > 0.02 * middle_distance_m_)) {
    return drawing::Point::Constant(std::numeric_limits<double>::quiet_NaN());
  }
  return origin_ + scale_ * drawing::Point(q.x() / q.z(), q.y() / q.z());
}

Line2 Onlooker::to_canvas(const Line3& line) const {
  Line2 image;
  for (const Eigen::Vector3d& p : line) {
    image.push_back(to_canvas(p));
  }
  return image;
}

std::vector<Line3> camera_pyramid(const Se3& T_world_cam, const StereoGeometry& geometry, double depth_m) {
  std::array<Eigen::Vector3d, 4> corners;
  std::size_t next = 0;
  for (const auto& [u, v] : {std::pair{0.0, 0.0}, {1.0, 0.0}, {1.0, 1.0}, {0.0, 1.0}}) {
    const Eigen::Vector3d ray((u * geometry.width_px - geometry.cx_px) / geometry.fx_px,
                              (v * geometry.height_px - geometry.cy_px) / geometry.fy_px, 1.0);
    corners[next++] = T_world_cam * Eigen::Vector3d(ray * depth_m);
  }
  std::vector<Line3> edges{{corners[0], corners[1], corners[2], corners[3], corners[0]}};
  for (const Eigen::Vector3d& corner : corners) {
    edges.push_back({T_world_cam.translation, corner});
  }
  return edges;
}

std::size_t every_nth(std::size_t count, std::size_t most) {
  return std::max<std::size_t>(1, (count + most - 1) / std::max<std::size_t>(most, 1));
}

}  // namespace kinetrace::figure
