#include "world/mesh.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "util/random.hpp"

namespace kinetrace::simulator {
namespace {

using Eigen::Vector2f;
using Eigen::Vector3f;

constexpr float kTurn = 2.F * std::numbers::pi_v<float>;

std::uint32_t count_of(const std::vector<Mesh::Vertex>& vertices) {
  return static_cast<std::uint32_t>(vertices.size());
}

// A vector perpendicular to `axis`.
Vector3f across(const Vector3f& axis) {
  const Vector3f helper = std::abs(axis.y()) < 0.9F * axis.norm() ? Vector3f::UnitY() : Vector3f::UnitX();
  return axis.cross(helper).normalized();
}

}  // namespace

Eigen::Matrix3f turned(float angle_rad) {
  return Eigen::AngleAxisf(angle_rad, Vector3f::UnitY()).toRotationMatrix();
}

void Mesh::add_quad(const Vector3f& a, const Vector3f& b, const Vector3f& c, const Vector3f& d, const Paint& paint) {
  const Vector3f normal = (b - a).cross(d - a).normalized();
  const Vector3f along = (b - a).normalized();
  const Vector3f up = (d - a - along * along.dot(d - a)).normalized();
  const std::uint32_t first = count_of(vertices);
  for (const Vector3f& p : {a, b, c, d}) {
    vertices.push_back({p, normal, Vector2f(along.dot(p - a), up.dot(p - a))});
  }
  triangles.push_back({{first, first + 1, first + 2}, paint});
  triangles.push_back({{first, first + 2, first + 3}, paint});
}

void Mesh::add_triangle(const Vector3f& a, const Vector3f& b, const Vector3f& c, const Paint& paint) {
  add_quad(a, b, c, c, paint);
  triangles.pop_back();
}

void Mesh::add_box(const Vector3f& center, const Vector3f& size, const Paint& paint, const Eigen::Matrix3f& rotation) {
  const auto corner = [&](float x, float y, float z) -> Vector3f {
    return center + rotation * Vector3f(x * size.x(), y * size.y(), z * size.z()) * 0.5F;
  };
  // y points down: each side starts at a lower corner.
  add_quad(corner(-1, 1, -1), corner(1, 1, -1), corner(1, -1, -1), corner(-1, -1, -1), paint);
  add_quad(corner(1, 1, 1), corner(-1, 1, 1), corner(-1, -1, 1), corner(1, -1, 1), paint);
  add_quad(corner(-1, 1, 1), corner(-1, 1, -1), corner(-1, -1, -1), corner(-1, -1, 1), paint);
  add_quad(corner(1, 1, -1), corner(1, 1, 1), corner(1, -1, 1), corner(1, -1, -1), paint);
  add_quad(corner(-1, -1, -1), corner(1, -1, -1), corner(1, -1, 1), corner(-1, -1, 1), paint);
  add_quad(corner(-1, 1, 1), corner(1, 1, 1), corner(1, 1, -1), corner(-1, 1, -1), paint);
}

void Mesh::add_cylinder(const Vector3f& from, const Vector3f& to, float from_radius, float to_radius, int sides,
                        const Paint& paint) {
  const Vector3f axis = (to - from).normalized();
  const Vector3f e1 = across(axis);
  const Vector3f e2 = axis.cross(e1);
  const std::uint32_t first = count_of(vertices);
  for (int i = 0; i <= sides; ++i) {
    const float angle = kTurn * static_cast<float>(i) / static_cast<float>(sides);
    const Vector3f out = std::cos(angle) * e1 + std::sin(angle) * e2;
    const float along = angle * std::max(from_radius, to_radius);
    vertices.push_back({from + out * from_radius, out, Vector2f(along, 0.F)});
    vertices.push_back({to + out * to_radius, out, Vector2f(along, (to - from).norm())});
  }
  for (std::uint32_t i = 0; i < static_cast<std::uint32_t>(sides); ++i) {
    const std::uint32_t v = first + 2 * i;
    triangles.push_back({{v, v + 2, v + 1}, paint});
    triangles.push_back({{v + 1, v + 2, v + 3}, paint});
  }
  for (const bool at_end : {false, true}) {
    const std::uint32_t centre = count_of(vertices);
    const Vector3f normal = at_end ? axis : Vector3f(-axis);
    const Vector3f middle = at_end ? to : from;
    const float radius = at_end ? to_radius : from_radius;
    vertices.push_back({middle, normal, Vector2f::Zero()});
    for (int i = 0; i <= sides; ++i) {
      const float angle = kTurn * static_cast<float>(i) / static_cast<float>(sides);
      const Vector2f at(std::cos(angle) * radius, std::sin(angle) * radius);
      vertices.push_back({middle + at.x() * e1 + at.y() * e2, normal, at});
    }
    for (std::uint32_t i = 0; i < static_cast<std::uint32_t>(sides); ++i) {
      triangles.push_back({{centre, centre + 1 + i, centre + 2 + i}, paint});
    }
  }
}

void Mesh::add_ellipsoid(const Vector3f& center, const Vector3f& radii, int rings, const Paint& paint,
                         float roughness) {
  const int segments = 2 * rings;
  const std::size_t first_triangle = triangles.size();
  const std::uint32_t first = count_of(vertices);
  for (int i = 0; i <= rings; ++i) {
    const float polar = std::numbers::pi_v<float> * static_cast<float>(i) / static_cast<float>(rings);
    for (int j = 0; j < segments; ++j) {
      const float azimuth = kTurn * static_cast<float>(j) / static_cast<float>(segments);
      const Vector3f out(std::sin(polar) * std::cos(azimuth), -std::cos(polar), std::sin(polar) * std::sin(azimuth));
      // Both poles are single points, whatever the azimuth.
      const int key = i == 0 || i == rings ? 0 : j;
      const float radius = 1.F + roughness * (2.F * unit_float(hash_of(paint.seed, i, key)) - 1.F);
      vertices.push_back({center + radius * radii.cwiseProduct(out), out.cwiseQuotient(radii).normalized(),
                          Vector2f(azimuth * radii.x(), (polar - 1.57F) * -radii.y())});
    }
  }
  const auto at = [&](int i, int j) { return first + static_cast<std::uint32_t>(i * segments + j % segments); };
  for (int i = 0; i < rings; ++i) {
    for (int j = 0; j < segments; ++j) {
      triangles.push_back({{at(i, j), at(i + 1, j), at(i + 1, j + 1)}, paint});
      triangles.push_back({{at(i, j), at(i + 1, j + 1), at(i, j + 1)}, paint});
    }
  }
  if (roughness > 0.F) {
    smooth_normals(first, first_triangle);
  }
}

void Mesh::add_loft(std::span<const std::vector<Vector3f>> rings, const Paint& paint) {
  const std::uint32_t first = count_of(vertices);
  const std::size_t first_triangle = triangles.size();
  const auto points = static_cast<std::uint32_t>(rings.front().size());
  for (const std::vector<Vector3f>& ring : rings) {
    for (const Vector3f& point : ring) {
      vertices.push_back({point, Vector3f::Zero(), Vector2f::Zero()});
    }
  }
  for (std::uint32_t i = 0; i + 1 < rings.size(); ++i) {
    for (std::uint32_t j = 0; j < points; ++j) {
      const std::uint32_t k = (j + 1) % points;
      const std::uint32_t here = first + i * points;
      const std::uint32_t next = here + points;
      triangles.push_back({{here + j, next + j, next + k}, paint});
      triangles.push_back({{here + j, next + k, here + k}, paint});
    }
  }
  for (const bool at_end : {false, true}) {
    const std::uint32_t ring = first + (at_end ? static_cast<std::uint32_t>(rings.size() - 1) * points : 0U);
    for (std::uint32_t j = 1; j + 1 < points; ++j) {
      triangles.push_back({{ring, ring + j + (at_end ? 0U : 1U), ring + j + (at_end ? 1U : 0U)}, paint});
    }
  }
  smooth_normals(first, first_triangle);
}

// Area-weighted mean of the faces around each vertex.
void Mesh::smooth_normals(std::size_t first_vertex, std::size_t first_triangle) {
  for (std::size_t v = first_vertex; v < vertices.size(); ++v) {
    vertices[v].normal.setZero();
  }
  for (std::size_t t = first_triangle; t < triangles.size(); ++t) {
    const auto& [a, b, c] = triangles[t].corners;
    const Vector3f face =
        (vertices[b].position - vertices[a].position).cross(vertices[c].position - vertices[a].position);
    for (const std::uint32_t corner : {a, b, c}) {
      vertices[corner].normal += face;
    }
  }
  for (std::size_t v = first_vertex; v < vertices.size(); ++v) {
    const float length = vertices[v].normal.norm();
    vertices[v].normal = length > 0.F ? Vector3f(vertices[v].normal / length) : Vector3f(0.F, -1.F, 0.F);
  }
}

void Mesh::scale(float factor) {
  for (Vertex& vertex : vertices) {
    vertex.position *= factor;
    vertex.uv *= factor;
  }
}

void Mesh::append(const Mesh& other, const Eigen::Matrix3f& rotation, const Vector3f& translation) {
  const std::uint32_t first = count_of(vertices);
  for (const Vertex& vertex : other.vertices) {
    vertices.push_back({rotation * vertex.position + translation, rotation * vertex.normal, vertex.uv});
  }
  for (Triangle triangle : other.triangles) {
    for (std::uint32_t& corner : triangle.corners) {
      corner += first;
    }
    triangles.push_back(triangle);
  }
}

}  // namespace kinetrace::simulator
