// Spatial index of the triangles of a static world, for tests of collisions and ground contact.
#pragma once

#include <array>
#include <optional>
#include <utility>
#include <vector>

#include <Eigen/Core>

#include "world/scene.hpp"

namespace kinetrace::simulator {

/// An oriented box: half extents along the axes of its pose.
struct SolidBox {
  Se3 T_scene_box;
  Eigen::Vector3d half_m = Eigen::Vector3d::Zero();
};

/// The triangles of a mesh, sorted into squares on the ground. `mesh` must outlive it.
class GroundIndex {
 public:
  explicit GroundIndex(const Mesh& mesh);

  /// A triangle of the mesh that reaches into the box, if there is one.
  [[nodiscard]] std::optional<std::size_t> reaches_into(const SolidBox& box) const;
  /// Height over the scene's ground of the highest surface at (x, z) that is no higher than `below_m`.
  [[nodiscard]] double height_m(double x_m, double z_m, double below_m) const;

 private:
  using Corners = std::array<Eigen::Vector3d, 3>;
  [[nodiscard]] Corners corners(std::size_t triangle) const;
  template <typename Visit>
  void visit(double x0, double x1, double z0, double z1, const Visit& visit_triangle) const;

  const Mesh& mesh_;
  Eigen::Array2i first_cell_ = Eigen::Array2i::Zero();
  Eigen::Array2i cells_ = Eigen::Array2i::Zero();
  std::vector<std::vector<std::size_t>> triangles_;
};

}  // namespace kinetrace::simulator
