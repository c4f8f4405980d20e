// People: cloth with folds and prints, skin, shoes.
#include <algorithm>

#include "noise.hpp"
#include "pattern.hpp"
#include "textures.hpp"

namespace kinetrace::simulator {
namespace {

float cloth(const Paint& paint, const SurfacePoint& point) {
  static const Octaves folds(0.16F, 0.72F, 6, 501);
  const float base = 0.06F + 0.5F * unit_float(hash_of(paint.seed, 1));
  const bool striped = unit_float(hash_of(paint.seed, 2)) > 0.55F;
  const float width_m = std::max(point.footprint_m, 0.001F);
  const float stripe = striped ? stripes(point.position.y(), 0.08F, 0.035F, width_m) : 0.F;
  const float fold = fractal_noise(folds, point.position, point.footprint_m);
  return mix(base, base < 0.3F ? 0.6F : 0.08F, stripe) * std::max(0.3F, 1.F + 0.3F * fold);
}

float skin(const SurfacePoint& point) {
  static const Octaves tone(0.12F, 0.7F, 5, 502);
  return 0.36F + 0.05F * fractal_noise(tone, point.position, point.footprint_m);
}

}  // namespace

Look person_look(const Paint& paint, const SurfacePoint& point) {
  switch (paint.material) {
    case Material::kSkin: return {skin(point)};
    case Material::kShoe: return {0.07F, 0.02F};
    default: return {cloth(paint, point)};
  }
}

}  // namespace kinetrace::simulator
