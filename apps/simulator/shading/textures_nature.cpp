// Plants and bare ground.
#include "shading/noise_kernel.hpp"
#include "shading/pattern.hpp"
#include "shading/textures.hpp"

namespace kinetrace::simulator::KINETRACE_KERNEL_ISA {
namespace {

// Leaves in light over gaps in shade.
Floats foliage(const Paint& paint, const Points& point) {
  static const Octaves leaves(0.33F, 0.97F, 7, 301);
  const float bright = 0.16F + 0.1F * paint_value(paint.seed, 1);
  const Floats relief = fractal_noise(leaves, point.position, point.footprint_m);
  return bright * max(0.15F, 1.F + 0.62F * relief);
}

Floats grass(const Points& point) {
  static const Octaves blades(1.5F, 0.88F, 8, 302);
  return 0.15F * max(0.2F, 1.F + 0.5F * fractal_noise(blades, point.position, point.footprint_m));
}

Floats gravel(const Points& point) {
  static const Octaves stones(1.1F, 0.9F, 8, 303);
  return 0.28F * max(0.3F, 1.F + 0.4F * fractal_noise(stones, point.position, point.footprint_m));
}

Floats bark(const Points& point) {
  static const Octaves ridges(0.2F, 0.85F, 6, 304);
  const Vec3 stretched{point.position.x * 2.F, point.position.y * 0.5F, point.position.z * 2.F};
  return 0.14F * max(0.25F, 1.F + 0.5F * fractal_noise(ridges, stretched, 2.F * point.footprint_m));
}

}  // namespace

Looks nature_look(const Paint& paint, const Points& point) {
  switch (paint.material) {
    case Material::kGrass: return {grass(point)};
    case Material::kGravel: return {gravel(point)};
    case Material::kBark: return {bark(point)};
    default: return {foliage(paint, point)};
  }
}

}  // namespace kinetrace::simulator::KINETRACE_KERNEL_ISA
