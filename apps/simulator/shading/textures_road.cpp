// Streets: asphalt with stains and cracks, worn paint, covers, slabs.
#include "shading/noise_kernel.hpp"
#include "shading/pattern.hpp"
#include "shading/textures.hpp"

namespace kinetrace::simulator::KINETRACE_KERNEL_ISA {
namespace {

// Cracks run along the zero crossings of smooth noise. They are not resolved from a distance.
Floats crack(const Points& point) {
  static const Octaves meander(2.6F, 0.55F, 5, 101);
  const Floats seen = resolved(0.12F, point.footprint_m);
  if (!any(seen > 0.F)) {
    return 0.F;
  }
  const Floats distance_m = abs(fractal_noise(meander, point.position, point.footprint_m)) * 1.1F;
  const float half_width_m = 0.012F;
  const Floats width_m = max(point.footprint_m, 0.004F);
  return seen * clamp((half_width_m - distance_m) / width_m + 0.5F, 0.F, 1.F) * min(1.F, 2.F * half_width_m / width_m);
}

// Grit and stains; the extremes of the grit are lighter stones, and dark spots of chewing gum and oil.
Floats asphalt(const Points& point) {
  static const Octaves stains(3.F, 0.8F, 8, 102);
  static const Octaves grit(0.13F, 0.86F, 5, 103);
  const Floats stain = fractal_noise(stains, point.position, point.footprint_m);
  const Floats stone = fractal_noise(grit, point.position, point.footprint_m);
  const Floats base = 0.155F + 0.036F * stain + 0.034F * stone;
  return base * (1.F - 0.5F * soft_step(1.6F, 2.1F, -stone)) * (1.F + 0.7F * soft_step(1.7F, 2.2F, stone)) *
         (1.F - 0.6F * crack(point));
}

Floats road_mark(const Points& point) {
  static const Octaves wear(0.35F, 0.8F, 7, 104);
  const Floats worn = fractal_noise(wear, point.position, point.footprint_m);
  return mix(0.55F, 0.17F, soft_step(0.6F, 1.5F, worn)) + 0.03F * worn;
}

// Mended road, sealed with tar along its edge.
Floats patch(const Paint& paint, const Points& point) {
  static const Octaves grit(0.4F, 0.85F, 8, 105);
  const float base = 0.08F + 0.12F * paint_value(paint.seed, 1);
  return base + 0.022F * fractal_noise(grit, point.position, point.footprint_m);
}

Floats manhole(const Points& point) {
  static const Octaves rust(0.2F, 0.8F, 6, 106);
  const Floats width_m = max(point.footprint_m, 0.002F);
  const Floats r = length(point.u, point.v);
  const Floats ring = disc(r, 0.27F, width_m) - disc(r, 0.24F, width_m);
  const Floats ribs = stripes(point.u, 0.07F, 0.03F, width_m) * stripes(point.v, 0.07F, 0.03F, width_m);
  return 0.15F + 0.16F * ribs * disc(r, 0.23F, width_m) - 0.11F * ring +
         0.02F * fractal_noise(rust, point.position, point.footprint_m);
}

Floats sidewalk(const Points& point) {
  static const Octaves dirt(0.8F, 0.86F, 8, 107);
  constexpr float kSlab_m = 0.5F;
  const Floats width_m = max(point.footprint_m, 0.002F);
  const Floats x = point.position.x;
  const Floats z = point.position.z;
  const Floats row = floor_of(z / kSlab_m);
  const Floats shifted_x = x + select(is_even(row), 0.25F, 0.F);
  const Floats joints =
      1.F - (1.F - stripes(shifted_x, kSlab_m, 0.012F, width_m)) * (1.F - stripes(z, kSlab_m, 0.012F, width_m));
  const Floats slab = cell_value(floor_of(shifted_x / kSlab_m), row, 108) - 0.5F;
  return (0.33F + 0.13F * slab * resolved(kSlab_m, point.footprint_m) +
          0.05F * fractal_noise(dirt, point.position, point.footprint_m)) *
         (1.F - 0.6F * joints);
}

Floats curb(const Points& point) {
  static const Octaves grain(0.15F, 0.85F, 6, 109);
  const Floats joints = stripes(point.position.z, 1.F, 0.015F, max(point.footprint_m, 0.002F));
  const Floats stone = cell_value(floor_of(point.position.z), 0.F, 110) - 0.5F;
  return (0.42F + 0.08F * stone * resolved(1.F, point.footprint_m) +
          0.05F * fractal_noise(grain, point.position, point.footprint_m)) *
         (1.F - 0.6F * joints);
}

}  // namespace

Looks road_look(const Paint& paint, const Points& point) {
  switch (paint.material) {
    case Material::kRoadMark: return {road_mark(point)};
    case Material::kPatch: return {patch(paint, point)};
    case Material::kManhole: return {manhole(point)};
    case Material::kSidewalk: return {sidewalk(point)};
    case Material::kCurb: return {curb(point)};
    default: return {asphalt(point)};
  }
}

}  // namespace kinetrace::simulator::KINETRACE_KERNEL_ISA
