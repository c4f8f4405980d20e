// Triangle meshes with the data that textures need.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "world/surface.hpp"

namespace kinetrace::simulator {

/// Triangles in the frame of the body they belong to: x forward, y down, metres.
struct Mesh {
  using Vertex = SurfacePoint;
  struct Triangle {
    std::array<std::uint32_t, 3> corners{};
    Paint paint;
  };
  std::vector<Vertex> vertices;
  std::vector<Triangle> triangles;

  /// Flat quadrilateral a b c d; uv runs from (0, 0) at a, along ab and ad, in metres.
  void add_quad(const Eigen::Vector3f& a, const Eigen::Vector3f& b, const Eigen::Vector3f& c, const Eigen::Vector3f& d,
                const Paint& paint);
  /// Flat triangle; uv as in add_quad with the third corner in d's place.
  void add_triangle(const Eigen::Vector3f& a, const Eigen::Vector3f& b, const Eigen::Vector3f& c, const Paint& paint);
  /// Box of the given size about `center`, turned by `rotation`. Sides get uv along and up from their lower corner.
  void add_box(const Eigen::Vector3f& center, const Eigen::Vector3f& size, const Paint& paint,
               const Eigen::Matrix3f& rotation = Eigen::Matrix3f::Identity());
  /// Closed cylinder from `from` to `to`, tapering from radius `from_radius` to `to_radius`.
  void add_cylinder(const Eigen::Vector3f& from, const Eigen::Vector3f& to, float from_radius, float to_radius,
                    int sides, const Paint& paint);
  /// Ellipsoid; with `roughness` > 0 its radius varies by that fraction, depending on `paint.seed`.
  void add_ellipsoid(const Eigen::Vector3f& center, const Eigen::Vector3f& radii, int rings, const Paint& paint,
                     float roughness = 0.F);
  /// A closed skin over rings of equally many points, with smooth normals. uv is zero.
  void add_loft(std::span<const std::vector<Eigen::Vector3f>> rings, const Paint& paint);
  /// About the origin; `factor` > 0.
  void scale(float factor);
  /// Adds `other`, moved.
  void append(const Mesh& other, const Eigen::Matrix3f& rotation, const Eigen::Vector3f& translation);

 private:
  void smooth_normals(std::size_t first_vertex, std::size_t first_triangle);
};

/// Turned by `angle_rad` about the vertical; positive from x (forward) towards -z.
[[nodiscard]] Eigen::Matrix3f turned(float angle_rad);

}  // namespace kinetrace::simulator
