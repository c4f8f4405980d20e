#include "figure/figure_views.hpp"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>

namespace kinetrace::figure {

std::vector<Line3> edges_of(const Box3& box) {
  const auto corners = box.corners();
  std::vector<Line3> edges;
  for (std::size_t i = 0; i < corners.size(); ++i) {
    for (const std::size_t axis : {std::size_t{1}, std::size_t{2}, std::size_t{4}}) {
      if ((i & axis) == 0) {
        edges.push_back({corners[i], corners[i | axis]});
      }
    }
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
      if (!a.allFinite() || !b.allFinite() || std::max(a.z(), b.z()) < kMinProjectionDepth_m) {
        continue;
      }
      // The end behind the camera moves to the nearest plane.
      for (auto [near, far] : {std::pair{&a, &b}, std::pair{&b, &a}}) {
        if (near->z() < kMinProjectionDepth_m) {
          *near += (*far - *near) * ((kMinProjectionDepth_m - near->z()) / (far->z() - near->z()));
        }
      }
      const Eigen::Vector3d from = geometry.project(a);
      const Eigen::Vector3d to = geometry.project(b);
      images.push_back({place.to_canvas(from.x(), from.y()), place.to_canvas(to.x(), to.y())});
    }
  }
  return images;
}

namespace {

using drawing::Range;

/// Range of `value(p)` over the subject: `points` without outliers, and nearly all of `whole`. Values that are not
/// finite are ignored.
template <typename Value>
Range range_of(const Onlooker::Subject& subject, const Range& fallback, Value&& value) {
  constexpr double kWildOfWhole = 0.004;
  std::vector<double> of_points;
  std::vector<double> of_whole;
  std::transform(subject.points.begin(), subject.points.end(), std::back_inserter(of_points), value);
  std::transform(subject.whole.begin(), subject.whole.end(), std::back_inserter(of_whole), value);
  const auto points = drawing::quantile_range(of_points, subject.outlier_share);
  const auto whole = drawing::quantile_range(of_whole, kWildOfWhole);
  if (!points || !whole) {
    return points.value_or(whole.value_or(fallback));
  }
  return {std::min(points->low, whole->low), std::max(points->high, whole->high)};
}

/// Rows: right, down and forward of the onlooker.
Eigen::Matrix3d axes_of(const Onlooker::Direction& direction) {
  const Eigen::Vector3d down = direction.down.normalized();
  Eigen::Vector3d level = direction.forward - down * down.dot(direction.forward);
  if (level.norm() < 1e-6) {
    level = down.unitOrthogonal();
  }
  // Moving around to the left turns the view to the right; rising tilts it down.
  const Eigen::Vector3d turned = Eigen::AngleAxisd(direction.aside_rad, down) * level.normalized();
  const Eigen::Vector3d forward = std::cos(direction.elevated_rad) * turned + std::sin(direction.elevated_rad) * down;
  const Eigen::Vector3d right = down.cross(forward).normalized();
  Eigen::Matrix3d rows;
  rows.row(0) = right;
  rows.row(1) = forward.cross(right);
  rows.row(2) = forward;
  return rows;
}

}  // namespace

Onlooker::Onlooker(const Direction& direction, const Subject& subject, const drawing::Rect& area)
    : R_view_(axes_of(direction)) {
  const Range nothing{-0.5, 0.5};
  Eigen::Vector3d middle;
  Eigen::Vector3d size;
  for (Eigen::Index axis = 0; axis < 3; ++axis) {
    const Range range = range_of(subject, nothing, [&](const Eigen::Vector3d& p) { return R_view_.row(axis).dot(p); });
    constexpr double kMin_m = 0.05;
    middle[axis] = range.center();
    size[axis] = std::max(range.size(), kMin_m);
  }
  // At this distance the nearest points appear about 1.6 times as large as the farthest.
  middle_distance_m_ = 0.5 * size.norm() + 1.6 * size.z();
  view_ = R_view_.transpose() * (middle - Eigen::Vector3d(0.0, 0.0, middle_distance_m_));

  // In the image plane at unit distance; points beside or behind the onlooker are ignored.
  const auto seen_range = [&](Eigen::Index axis) {
    constexpr double kMargin = 0.05;
    const auto seen = [&](const Eigen::Vector3d& p) {
      const Eigen::Vector3d q = R_view_ * (p - view_);
      return q.z() > 0.1 * middle_distance_m_ ? q[axis] / q.z() : std::numeric_limits<double>::quiet_NaN();
    };
    return range_of(subject, nothing, seen).at_least(1e-3).widened(kMargin);
  };
  const Range x = seen_range(0);
  const Range y = seen_range(1);
  scale_ = std::min(area.width / x.size(), area.height / y.size());
  origin_ = area.center() - scale_ * drawing::Point(x.center(), y.center());
}

drawing::Point Onlooker::to_canvas(const Eigen::Vector3d& p) const {
  const Eigen::Vector3d q = R_view_ * (p - view_);
  if (!(q.z() > 0.02 * middle_distance_m_)) {
    return drawing::Point::Constant(std::numeric_limits<double>::quiet_NaN());
  }
  return origin_ + scale_ * drawing::Point(q.x() / q.z(), q.y() / q.z());
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
