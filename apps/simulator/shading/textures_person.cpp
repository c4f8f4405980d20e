// People: clothes with folds and prints, hair, skin, shoes.
#include "shading/noise_kernel.hpp"
#include "shading/pattern.hpp"
#include "shading/textures.hpp"

namespace kinetrace::simulator::KINETRACE_KERNEL_ISA {
namespace {

Floats merged(Floats albedo, const Octaves& folds, const Points& point) {
  return albedo * max(0.3F, 1.F + 0.3F * fractal_noise(folds, point.position, point.footprint_m));
}

// Shirts: plain, striped, chequered, or with a print on the chest.
Floats shirt(const Paint& paint, const Points& point) {
  static const Octaves folds(0.16F, 0.72F, 6, 501);
  const float base = 0.06F + 0.5F * paint_value(paint.seed, 1);
  const float other = base < 0.3F ? 0.6F : 0.08F;
  const Floats width_m = max(point.footprint_m, 0.001F);
  const Vec3& p = point.position;
  Floats pattern = 0.F;
  switch (hash_of(paint.seed, 2) % 4) {
    case 0: pattern = stripes(p.y, 0.07F, 0.03F, width_m); break;
    case 1: pattern = 0.5F * (stripes(p.y, 0.09F, 0.035F, width_m) + stripes(p.z, 0.09F, 0.035F, width_m)); break;
    case 2: pattern = band(p.z, -0.1F, 0.1F, width_m) * band(p.y, -0.42F, -0.28F, width_m); break;
    default: break;
  }
  return merged(mix(base, other, pattern), folds, point);
}

Floats trousers(const Paint& paint, const Points& point) {
  static const Octaves folds(0.2F, 0.78F, 7, 503);
  return merged(0.05F + 0.22F * paint_value(paint.seed, 1), folds, point);
}

Floats hair(const Paint& paint, const Points& point) {
  static const Octaves strands(0.05F, 0.8F, 5, 504);
  return merged(0.03F + 0.2F * paint_value(paint.seed, 1), strands, point);
}

Floats skin(const Points& point) {
  static const Octaves tone(0.12F, 0.7F, 5, 502);
  return 0.36F + 0.05F * fractal_noise(tone, point.position, point.footprint_m);
}

}  // namespace

Looks person_look(const Paint& paint, const Points& point) {
  switch (paint.material) {
    case Material::kSkin: return {skin(point)};
    case Material::kShoe: return {0.07F, 0.02F};
    case Material::kTrousers: return {trousers(paint, point)};
    case Material::kHair: return {hair(paint, point)};
    default: return {shirt(paint, point)};
  }
}

}  // namespace kinetrace::simulator::KINETRACE_KERNEL_ISA
