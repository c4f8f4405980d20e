// Points of surfaces and of the sky that wait to be shaded, until there are eight of a kind.
#pragma once

#include <array>
#include <cstddef>
#include <vector>

#include <Eigen/Core>

#include "scene.hpp"
#include "shading_kernel.hpp"

namespace kinetrace::simulator {

/// A point on a surface with the ray that met it; see SurfacePack.
struct ShadedPoint {
  SurfacePoint local;
  float footprint_m = 0.F;
  Eigen::Vector3f normal;  ///< Scene frame.
  Eigen::Vector3f ray;
  float in_sun = 0.F;
};

/// Adds light to pixels. Which points are shaded together does not change what comes out, but for the order in which a
/// pixel's parts are added; that depends on the order of the calls alone.
class ShadingQueue {
 public:
  explicit ShadingQueue(const Light& light);

  /// `weight` times the point's light will be added to `pixel`, which must live until finish(). So must `paint`.
  void add(const Paint& paint, const ShadedPoint& point, float weight, float& pixel);
  /// The same for all points of a strip, which are like `point` but for where they are.
  void add_strip(const Paint& paint, const ShadedPoint& point, const SurfaceStrip& strip, float weight, float& pixel);
  /// The same for the sky in a direction of any length.
  void add_sky(const Eigen::Vector3f& direction, float weight, float& pixel);
  /// Shades what still waits.
  void finish();

 private:
  // What the results of one pack are for.
  struct Targets {
    std::size_t count = 0;
    std::array<float*, kLanes> pixels{};
    std::array<float, kLanes> weights{};

    /// The first of the `lanes` that now belong to the pixel.
    std::size_t add(std::size_t lanes, float weight, float& pixel);
    [[nodiscard]] bool full() const noexcept { return count == kLanes; }
    void receive(const Lanes& radiance);
  };
  // Points of one look. Strips have their own groups, so that none begins in the middle of half a pack.
  struct Group {
    const Paint* paint = nullptr;
    bool strips = false;
    Targets targets;
    SurfacePack pack;
  };

  Group& group_of(const Paint& paint, bool strips);
  void shade(Group& group);
  void shade_sky();

  const ShadingKernel& kernel_;
  Daylight light_;
  std::vector<Group> groups_;  // The first `used_` of them.
  std::size_t used_ = 0;
  // Where a look was found before, by its hash.
  std::array<std::size_t, 64> recent_{};
  Targets sky_targets_;
  Lanes3 sky_directions_;
};

}  // namespace kinetrace::simulator
