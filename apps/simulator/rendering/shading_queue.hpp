// Queue of surface and sky points, shaded eight of a kind at a time.
#pragma once

#include <array>
#include <cstddef>
#include <vector>

#include <Eigen/Core>

#include "shading/shading_kernel.hpp"
#include "world/scene.hpp"

namespace kinetrace::simulator {

/// A point on a surface with the ray that met it; see SurfacePack.
struct ShadedPoint {
  SurfacePoint local;
  float footprint_m = 0.F;
  Eigen::Vector3f normal;  ///< Scene frame.
  Eigen::Vector3f ray;
  float in_sun = 0.F;
};

/// Adds light to pixels. Grouping does not change the result except for the order in which a pixel's parts are added;
/// that depends on the order of the calls alone.
class ShadingQueue {
 public:
  explicit ShadingQueue(const Light& light);

  /// `weight` times the point's light will be added to `pixel`, which must live until finish().
  void add(const Paint& paint, const ShadedPoint& point, float weight, float& pixel);
  /// The same for all points of a strip, which differ from `point` only in their position.
  void add_strip(const Paint& paint, const ShadedPoint& point, const SurfaceStrip& strip, float weight, float& pixel);
  /// The same for the sky in a direction of any length.
  void add_sky(const Eigen::Vector3f& direction, float weight, float& pixel);
  /// Shades the remaining points.
  void finish();

 private:
  // Destinations of the results of one pack.
  struct Targets {
    std::size_t count = 0;
    std::array<float*, kLanes> pixels{};
    std::array<float, kLanes> weights{};

    /// Index of the first of the `lanes` that now belong to the pixel.
    std::size_t add(std::size_t lanes, float weight, float& pixel);
    [[nodiscard]] bool full() const noexcept { return count == kLanes; }
    void receive(const Lanes& radiance);
  };
  // Points of one look. Strips have their own groups, so that none begins in the middle of half a pack.
  struct Group {
    Paint paint;
    bool strips = false;
    Targets targets;
    SurfacePack pack;

    [[nodiscard]] bool has(const Paint& look, bool in_strips) const noexcept {
      return paint == look && strips == in_strips;
    }
  };

  Group& group_of(const Paint& paint, bool strips);
  [[nodiscard]] std::size_t place_of(const Paint& paint, bool strips);
  void shade(Group& group);
  void shade_sky();

  const ShadingKernel& kernel_;
  Daylight light_;
  std::vector<Group> groups_;  // Only the first `used_` are valid.
  std::size_t used_ = 0;
  // Cache of group indices, by a hash of the look.
  std::array<std::size_t, 64> recent_{};
  Targets sky_targets_;
  Lanes3 sky_directions_;
};

// Called for every pixel: inlined, so that points stay in registers.

inline std::size_t ShadingQueue::Targets::add(std::size_t lanes, float weight, float& pixel) {
  const std::size_t first = count;
  for (; count < first + lanes; ++count) {
    pixels[count] = &pixel;
    weights[count] = weight;
  }
  return first;
}

inline ShadingQueue::Group& ShadingQueue::group_of(const Paint& paint, bool strips) {
  const std::size_t hash =
      2U * (static_cast<std::size_t>(paint.material) + std::size_t{5} * paint.seed) + (strips ? 1U : 0U);
  std::size_t& recent = recent_[hash % recent_.size()];
  if (recent >= used_ || !groups_[recent].has(paint, strips)) {
    recent = place_of(paint, strips);
  }
  return groups_[recent];
}

inline void ShadingQueue::add(const Paint& paint, const ShadedPoint& point, float weight, float& pixel) {
  Group& group = group_of(paint, false);
  const std::size_t lane = group.targets.add(1, weight, pixel);
  SurfacePack& pack = group.pack;
  pack.position.set(lane, point.local.position);
  pack.normal.set(lane, point.local.normal);
  pack.u[lane] = point.local.uv.x();
  pack.v[lane] = point.local.uv.y();
  pack.footprint_m[lane] = point.footprint_m;
  pack.scene_normal.set(lane, point.normal);
  pack.ray.set(lane, point.ray);
  pack.in_sun[lane] = point.in_sun;
  if (group.targets.full()) {
    shade(group);
  }
}

inline void ShadingQueue::add_strip(const Paint& paint, const ShadedPoint& point, const SurfaceStrip& strip,
                                    float weight, float& pixel) {
  Group& group = group_of(paint, true);
  const std::size_t lane = group.targets.add(kStripLanes, weight, pixel);
  SurfacePack& pack = group.pack;
  const auto set = [lane](Lanes& lanes, const StripLanes& values) { StripLanes::Map(lanes.data() + lane) = values; };
  const auto set_all = [lane](Lanes& lanes, float value) { StripLanes::Map(lanes.data() + lane).setConstant(value); };
  set(pack.position.x, strip.position.x);
  set(pack.position.y, strip.position.y);
  set(pack.position.z, strip.position.z);
  set_all(pack.normal.x, point.local.normal.x());
  set_all(pack.normal.y, point.local.normal.y());
  set_all(pack.normal.z, point.local.normal.z());
  set(pack.u, strip.u);
  set(pack.v, strip.v);
  set_all(pack.footprint_m, point.footprint_m);
  set_all(pack.scene_normal.x, point.normal.x());
  set_all(pack.scene_normal.y, point.normal.y());
  set_all(pack.scene_normal.z, point.normal.z());
  set(pack.ray.x, strip.ray.x);
  set(pack.ray.y, strip.ray.y);
  set(pack.ray.z, strip.ray.z);
  set_all(pack.in_sun, point.in_sun);
  if (group.targets.full()) {
    shade(group);
  }
}

}  // namespace kinetrace::simulator
