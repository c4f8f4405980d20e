#include "ground_index.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace kinetrace::simulator {
namespace {

using Eigen::Vector3d;

constexpr double kCell_m = 2.0;

int cell_of(double at_m) {
  return static_cast<int>(std::floor(at_m / kCell_m));
}

// Clips a polygon to the inner side of a plane across `axis` (I. Sutherland and G. Hodgman, "Reentrant
// polygon clipping", 1974).
std::vector<Vector3d> clipped(const std::vector<Vector3d>& polygon, int axis, double side, double limit) {
  std::vector<Vector3d> result;
  for (std::size_t i = 0; i < polygon.size(); ++i) {
    const Vector3d& a = polygon[i];
    const Vector3d& b = polygon[(i + 1) % polygon.size()];
    const double inside_a = limit - side * a[axis];
    const double inside_b = limit - side * b[axis];
    if (inside_a >= 0.0) {
      result.push_back(a);
    }
    if ((inside_a >= 0.0) != (inside_b >= 0.0)) {
      result.push_back(a + inside_a / (inside_a - inside_b) * (b - a));
    }
  }
  return result;
}

}  // namespace

GroundIndex::GroundIndex(const Mesh& mesh) : mesh_(mesh) {
  Eigen::Array2d low(std::numeric_limits<double>::infinity(), std::numeric_limits<double>::infinity());
  Eigen::Array2d high = -low;
  for (const Mesh::Vertex& vertex : mesh.vertices) {
    const Eigen::Array2d at(vertex.position.x(), vertex.position.z());
    low = low.min(at);
    high = high.max(at);
  }
  first_cell_ = {cell_of(low.x()), cell_of(low.y())};
  cells_ = Eigen::Array2i(cell_of(high.x()), cell_of(high.y())) - first_cell_ + 1;
  triangles_.resize(static_cast<std::size_t>(cells_.prod()));
  for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
    const Corners at = corners(i);
    const auto [x0, x1] = std::minmax({at[0].x(), at[1].x(), at[2].x()});
    const auto [z0, z1] = std::minmax({at[0].z(), at[1].z(), at[2].z()});
    for (int x = cell_of(x0); x <= cell_of(x1); ++x) {
      for (int z = cell_of(z0); z <= cell_of(z1); ++z) {
        triangles_[static_cast<std::size_t>((z - first_cell_.y()) * cells_.x() + x - first_cell_.x())].push_back(i);
      }
    }
  }
}

GroundIndex::Corners GroundIndex::corners(std::size_t triangle) const {
  const auto& [a, b, c] = mesh_.triangles[triangle].corners;
  return {mesh_.vertices[a].position.cast<double>(), mesh_.vertices[b].position.cast<double>(),
          mesh_.vertices[c].position.cast<double>()};
}

template <typename Visit>
void GroundIndex::visit(double x0, double x1, double z0, double z1, const Visit& visit_triangle) const {
  const int column0 = std::max(cell_of(x0) - first_cell_.x(), 0);
  const int column1 = std::min(cell_of(x1) - first_cell_.x(), cells_.x() - 1);
  const int row0 = std::max(cell_of(z0) - first_cell_.y(), 0);
  const int row1 = std::min(cell_of(z1) - first_cell_.y(), cells_.y() - 1);
  for (int row = row0; row <= row1; ++row) {
    for (int column = column0; column <= column1; ++column) {
      for (const std::size_t triangle : triangles_[static_cast<std::size_t>(row * cells_.x() + column)]) {
        visit_triangle(triangle);
      }
    }
  }
}

std::optional<std::size_t> GroundIndex::reaches_into(const SolidBox& box) const {
  const Vector3d reach = box.T_scene_box.rotation.cwiseAbs() * box.half_m;
  const Vector3d& centre = box.T_scene_box.translation;
  const Se3 T_box_scene = box.T_scene_box.inverse();
  std::optional<std::size_t> found;
  visit(centre.x() - reach.x(), centre.x() + reach.x(), centre.z() - reach.z(), centre.z() + reach.z(),
        [&](std::size_t triangle) {
          const Corners at = corners(triangle);
          const auto [y0, y1] = std::minmax({at[0].y(), at[1].y(), at[2].y()});
          if (found || y0 > centre.y() + reach.y() || y1 < centre.y() - reach.y()) {
            return;
          }
          std::vector<Vector3d> left;
          std::transform(at.begin(), at.end(), std::back_inserter(left),
                         [&](const Vector3d& p) { return T_box_scene * p; });
          for (int axis = 0; axis < 3; ++axis) {
            left = clipped(clipped(left, axis, 1.0, box.half_m[axis]), axis, -1.0, box.half_m[axis]);
          }
          if (!left.empty()) {
            found = triangle;
          }
        });
  return found;
}

double GroundIndex::height_m(double x_m, double z_m, double below_m) const {
  double highest_m = -std::numeric_limits<double>::infinity();
  visit(x_m, x_m, z_m, z_m, [&](std::size_t triangle) {
    const auto [a, b, c] = corners(triangle);
    Eigen::Matrix2d edges;
    edges << b.x() - a.x(), c.x() - a.x(), b.z() - a.z(), c.z() - a.z();
    if (std::abs(edges.determinant()) < 1e-9) {
      return;
    }
    const Eigen::Vector2d uv = edges.inverse() * Eigen::Vector2d(x_m - a.x(), z_m - a.z());
    const double height_m = -(a.y() + uv.x() * (b.y() - a.y()) + uv.y() * (c.y() - a.y()));
    if (uv.minCoeff() >= 0.0 && uv.sum() <= 1.0 && height_m <= below_m) {
      highest_m = std::max(highest_m, height_m);
    }
  });
  return highest_m;
}

}  // namespace kinetrace::simulator
