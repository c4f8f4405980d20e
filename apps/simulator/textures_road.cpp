// Streets: asphalt with stains and cracks, worn paint, covers, slabs.
#include <cmath>

#include "noise.hpp"
#include "pattern.hpp"
#include "textures.hpp"

namespace kinetrace::simulator {
namespace {

// Cracks run where a wandering value crosses zero. From afar they are too fine to be seen.
float crack(const SurfacePoint& point) {
  static const Octaves wander(2.6F, 0.55F, 5, 101);
  const float seen = resolved(0.12F, point.footprint_m);
  if (seen == 0.F) {
    return 0.F;
  }
  const float distance_m = std::abs(fractal_noise(wander, point.position, point.footprint_m)) * 1.1F;
  const float half_width_m = 0.012F;
  const float width_m = std::max(point.footprint_m, 0.004F);
  return seen * std::clamp((half_width_m - distance_m) / width_m + 0.5F, 0.F, 1.F) *
         std::min(1.F, 2.F * half_width_m / width_m);
}

// Grit and stains; the extremes of the grit are lighter stones, and dark spots of chewing gum and oil.
float asphalt(const SurfacePoint& point) {
  static const Octaves stains(3.F, 0.8F, 8, 102);
  static const Octaves grit(0.13F, 0.86F, 5, 103);
  const float stain = fractal_noise(stains, point.position, point.footprint_m);
  const float stone = fractal_noise(grit, point.position, point.footprint_m);
  const float base = 0.155F + 0.036F * stain + 0.034F * stone;
  return base * (1.F - 0.5F * soft_step(1.6F, 2.1F, -stone)) * (1.F + 0.7F * soft_step(1.7F, 2.2F, stone)) *
         (1.F - 0.6F * crack(point));
}

float road_mark(const SurfacePoint& point) {
  static const Octaves wear(0.35F, 0.8F, 7, 104);
  const float worn = fractal_noise(wear, point.position, point.footprint_m);
  return mix(0.55F, 0.17F, soft_step(0.6F, 1.5F, worn)) + 0.03F * worn;
}

// Mended road, sealed with tar along its edge.
float patch(const Paint& paint, const SurfacePoint& point) {
  static const Octaves grit(0.4F, 0.85F, 8, 105);
  const float base = 0.08F + 0.12F * unit_float(hash_of(paint.seed, 1));
  return base + 0.022F * fractal_noise(grit, point.position, point.footprint_m);
}

float manhole(const SurfacePoint& point) {
  static const Octaves rust(0.2F, 0.8F, 6, 106);
  const float width_m = std::max(point.footprint_m, 0.002F);
  const float r = point.uv.norm();
  const float ring = disc(r, 0.27F, width_m) - disc(r, 0.24F, width_m);
  const float ribs = stripes(point.uv.x(), 0.07F, 0.03F, width_m) * stripes(point.uv.y(), 0.07F, 0.03F, width_m);
  return 0.15F + 0.16F * ribs * disc(r, 0.23F, width_m) - 0.11F * ring +
         0.02F * fractal_noise(rust, point.position, point.footprint_m);
}

float sidewalk(const SurfacePoint& point) {
  static const Octaves dirt(0.8F, 0.86F, 8, 107);
  constexpr float kSlab_m = 0.5F;
  const float width_m = std::max(point.footprint_m, 0.002F);
  const float x = point.position.x();
  const float z = point.position.z();
  const float row = floor_of(z / kSlab_m);
  const float shifted_x = x + 0.25F * (static_cast<int>(row) % 2 == 0 ? 1.F : 0.F);
  const float joints =
      1.F - (1.F - stripes(shifted_x, kSlab_m, 0.012F, width_m)) * (1.F - stripes(z, kSlab_m, 0.012F, width_m));
  const float slab = cell_value(floor_of(shifted_x / kSlab_m), row, 108) - 0.5F;
  return (0.33F + 0.13F * slab * resolved(kSlab_m, point.footprint_m) +
          0.05F * fractal_noise(dirt, point.position, point.footprint_m)) *
         (1.F - 0.6F * joints);
}

float curb(const SurfacePoint& point) {
  static const Octaves grain(0.15F, 0.85F, 6, 109);
  const float joints = stripes(point.position.z(), 1.F, 0.015F, std::max(point.footprint_m, 0.002F));
  const float stone = cell_value(floor_of(point.position.z()), 0.F, 110) - 0.5F;
  return (0.42F + 0.08F * stone * resolved(1.F, point.footprint_m) +
          0.05F * fractal_noise(grain, point.position, point.footprint_m)) *
         (1.F - 0.6F * joints);
}

}  // namespace

Look road_look(const Paint& paint, const SurfacePoint& point) {
  switch (paint.material) {
    case Material::kRoadMark: return {road_mark(point)};
    case Material::kPatch: return {patch(paint, point)};
    case Material::kManhole: return {manhole(point)};
    case Material::kSidewalk: return {sidewalk(point)};
    case Material::kCurb: return {curb(point)};
    default: return {asphalt(point)};
  }
}

}  // namespace kinetrace::simulator
