// Ray tracing in the scene. Hides Embree (Wald et al., "Embree: a kernel framework for efficient CPU ray tracing",
// 2014).
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "world/scene.hpp"

namespace kinetrace::simulator {

/// Rays traced together; they should be nearly parallel. As many as Embree traverses its tree with at once.
struct alignas(32) RayPacket {
  static constexpr std::size_t kSize = 32;
  static constexpr std::uint32_t kMiss = ~0U;
  std::size_t count = 0;  ///< Number of rays; results of the others are undefined.
  alignas(32) std::array<float, kSize> origin_x{}, origin_y{}, origin_z{};
  alignas(32) std::array<float, kSize> direction_x{}, direction_y{}, direction_z{};
  // Results of trace(): distance in units of the direction's length; body part and triangle hit, or kMiss.
  alignas(32) std::array<float, kSize> distance{}, u{}, v{};
  alignas(32) std::array<std::uint32_t, kSize> part{}, triangle{};
  // Result of trace_shadow().
  alignas(32) std::array<bool, kSize> blocked{};

  void set_origin(std::size_t ray, const Eigen::Vector3f& origin) noexcept {
    origin_x[ray] = origin.x();
    origin_y[ray] = origin.y();
    origin_z[ray] = origin.z();
  }
  void set_direction(std::size_t ray, const Eigen::Vector3f& direction) noexcept {
    direction_x[ray] = direction.x();
    direction_y[ray] = direction.y();
    direction_z[ray] = direction.z();
  }
};

class RayWorld {
 public:
  /// `scene` must outlive the world. Throws std::runtime_error if Embree refuses.
  explicit RayWorld(const Scene& scene);
  ~RayWorld();
  RayWorld(const RayWorld&) = delete;
  RayWorld& operator=(const RayWorld&) = delete;

  /// Data of a triangle for shading a hit, in two cache lines.
  struct alignas(64) Facet {
    std::array<Mesh::Vertex, 3> corners;
    Eigen::Vector3f normal;  ///< Unit length, part's frame.
    bool flat = false;       ///< The corners' normals are the face's own.
    Paint paint;
  };
  /// Maps a step in a triangle's plane to a step of uv.
  using UvSlope = Eigen::Matrix<float, 2, 3>;
  /// One rigid mesh in the scene.
  struct Part {
    const Mesh* mesh = nullptr;
    std::vector<Facet> facets;       ///< Of the mesh's triangles.
    std::vector<UvSlope> uv_slopes;  ///< Of the mesh's triangles.
    Eigen::AlignedBox3f box;         ///< About the mesh, part's frame.
    int actor = -1;                  ///< Index into Scene::actors; -1 for the static world.
    Eigen::Matrix3f R_scene_part = Eigen::Matrix3f::Identity();
    Eigen::Vector3f t_scene_part = Eigen::Vector3f::Zero();
  };

  /// Moves all actors to their poses at `time_s`. Not while rays are being traced.
  void set_time(double time_s);

  /// Candidates for hits: the static world alone if the caller knows that no actor can be hit.
  enum class Reach { kEverything, kStaticWorld };

  void trace(RayPacket& packet, Reach reach = Reach::kEverything) const;
  /// Whether the sun is blocked from the rays' origins; directions need not be set.
  void trace_shadow(RayPacket& packet) const;
  /// Whether the ray meets this part, ignoring everything in front of it.
  [[nodiscard]] bool meets_part(std::size_t part, const Eigen::Vector3f& origin,
                                const Eigen::Vector3f& direction) const;

  /// Rectangles of (x / z, y / z), in the view of a camera that looks along z, outside of which there is no actor.
  [[nodiscard]] std::vector<Eigen::AlignedBox2f> actors_in_view(const Se3& T_scene_view) const;

  [[nodiscard]] std::span<const Part> parts() const noexcept { return parts_; }
  /// Index into Scene::actors plus one of the part's actor; 0 for the static world.
  [[nodiscard]] std::uint16_t actor_label(std::uint32_t part) const noexcept {
    return static_cast<std::uint16_t>(parts_[part].actor + 1);
  }
  [[nodiscard]] const Scene& scene() const noexcept { return scene_; }

 private:
  struct Handles;
  void cast_outlines();
  [[nodiscard]] bool may_be_shaded_by_actor(const RayPacket& packet) const;

  const Scene& scene_;
  Eigen::Vector3f to_sun_;
  Eigen::Matrix<float, 2, 3> across_sun_;      // Two directions at right angles to the sun's.
  std::vector<Eigen::AlignedBox2f> outlines_;  // Of the actors, as the sun sees them: across_sun_ * position.
  std::vector<Part> parts_;
  std::unique_ptr<Handles> handles_;
};

}  // namespace kinetrace::simulator
