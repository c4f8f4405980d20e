// The scene as rays see it. Hides Embree (Wald et al., "Embree: a kernel framework for efficient CPU ray tracing",
// 2014).
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include <Eigen/Core>

#include "scene.hpp"

namespace kinetrace::simulator {

/// Sixteen rays traced together; they should point about the same way.
struct alignas(64) RayPacket {
  static constexpr int kSize = 16;
  static constexpr std::uint32_t kMiss = ~0U;
  alignas(64) std::array<std::int32_t, kSize> active{};  ///< -1 for rays to trace, 0 for others.
  alignas(64) std::array<float, kSize> origin_x{}, origin_y{}, origin_z{};
  alignas(64) std::array<float, kSize> direction_x{}, direction_y{}, direction_z{};
  // Results of trace(): distance in units of the direction's length; body part and triangle hit, or kMiss.
  alignas(64) std::array<float, kSize> distance{}, u{}, v{};
  alignas(64) std::array<std::uint32_t, kSize> part{}, triangle{};
  // Result of trace_shadow().
  alignas(64) std::array<bool, kSize> blocked{};
};

class RayWorld {
 public:
  /// `scene` must outlive the world. Throws std::runtime_error if Embree refuses.
  explicit RayWorld(const Scene& scene);
  ~RayWorld();
  RayWorld(const RayWorld&) = delete;
  RayWorld& operator=(const RayWorld&) = delete;

  /// What every hit on a triangle needs, computed once.
  struct Face {
    Eigen::Vector3f normal;  ///< Unit length, part's frame.
    bool flat = false;       ///< The corners' normals are the face's own.
  };
  /// Takes a step in a triangle's plane to the step of uv.
  using UvSlope = Eigen::Matrix<float, 2, 3>;
  /// One rigid mesh in the scene.
  struct Part {
    const Mesh* mesh = nullptr;
    std::vector<Face> faces;         ///< Of the mesh's triangles.
    std::vector<UvSlope> uv_slopes;  ///< Of the mesh's triangles.
    int actor = -1;                  ///< Index into Scene::actors; -1 for the static world.
    Eigen::Matrix3f R_scene_part = Eigen::Matrix3f::Identity();
    Eigen::Vector3f t_scene_part = Eigen::Vector3f::Zero();
  };

  /// Moves everything to where it is at `time_s`. Not while rays are being traced.
  void set_time(double time_s);

  void trace(RayPacket& packet) const;
  void trace_shadow(RayPacket& packet) const;
  /// True if the ray meets this part, whatever stands before it.
  [[nodiscard]] bool meets_part(std::size_t part, const Eigen::Vector3f& origin,
                                const Eigen::Vector3f& direction) const;

  [[nodiscard]] std::span<const Part> parts() const noexcept { return parts_; }
  /// Index into Scene::actors plus one of the actor that a part belongs to; 0 for the static world.
  [[nodiscard]] std::uint16_t actor_label(std::uint32_t part) const noexcept {
    return static_cast<std::uint16_t>(parts_[part].actor + 1);
  }
  [[nodiscard]] const Scene& scene() const noexcept { return scene_; }

 private:
  struct Handles;
  const Scene& scene_;
  std::vector<Part> parts_;
  std::unique_ptr<Handles> handles_;
};

}  // namespace kinetrace::simulator
