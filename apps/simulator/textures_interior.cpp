// Rooms and what stands in them; also the plain surface of the textureless scene.
#include <cmath>

#include "noise.hpp"
#include "pattern.hpp"
#include "textures.hpp"

namespace kinetrace::simulator {
namespace {

float cardboard(const Paint& paint, const SurfacePoint& point) {
  static const Octaves fibre(0.2F, 0.85F, 7, 601);
  const float width_m = std::max(point.footprint_m, 0.001F);
  const float tape = band(point.uv.x(), 0.2F, 0.25F, width_m);
  const float label = band(point.uv.x(), 0.05F, 0.17F, width_m) * band(point.uv.y(), 0.08F, 0.2F, width_m);
  const float writing = cell_value(floor_of(point.uv.x() / 0.012F), floor_of(point.uv.y() / 0.016F), paint.seed);
  const float ink = mix(0.5F, writing > 0.55F ? 1.F : 0.F, resolved(0.012F, point.footprint_m));
  const float paper = 0.3F + 0.12F * unit_float(hash_of(paint.seed, 1)) +
                      0.035F * fractal_noise(fibre, point.position, point.footprint_m);
  return mix(mix(paper, 0.5F, tape), mix(0.8F, 0.1F, ink), label);
}

float floor_tiles(const SurfacePoint& point) {
  static const Octaves marble(0.5F, 0.93F, 8, 602);
  constexpr float kTile_m = 0.4F;
  const float width_m = std::max(point.footprint_m, 0.001F);
  const float x = point.position.x();
  const float z = point.position.z();
  const float joints =
      1.F - (1.F - stripes(x, kTile_m, 0.006F, width_m)) * (1.F - stripes(z, kTile_m, 0.006F, width_m));
  const float tile = cell_value(floor_of(x / kTile_m), floor_of(z / kTile_m), 603) - 0.5F;
  return (0.36F + 0.1F * tile * resolved(kTile_m, point.footprint_m) +
          0.07F * fractal_noise(marble, point.position, point.footprint_m)) *
         (1.F - 0.5F * joints);
}

float panel_wall(const Paint& paint, const SurfacePoint& point) {
  static const Octaves roughcast(0.4F, 0.93F, 8, 604);
  const float width_m = std::max(point.footprint_m, 0.001F);
  const float joints = stripes(point.uv.x(), 1.2F, 0.01F, width_m);
  const float skirting = band(point.uv.y(), 0.F, 0.1F, width_m);
  const float base = 0.45F + 0.15F * unit_float(hash_of(paint.seed, 1));
  return mix(base + 0.06F * fractal_noise(roughcast, point.position, point.footprint_m), 0.16F,
             std::max(0.6F * joints, skirting));
}

// A picture: patches of several sizes, as prints, books and notices have them.
float poster(const Paint& paint, const SurfacePoint& point) {
  static const Octaves ink(0.3F, 0.75F, 7, 605);
  float value = 0.4F + 0.07F * fractal_noise(ink, point.position, point.footprint_m);
  for (int level = 0; level < 3; ++level) {
    const float cell_m = std::ldexp(0.24F, -level);
    const float patch = cell_value(floor_of(point.uv.x() / cell_m), floor_of(point.uv.y() / cell_m),
                                   paint.seed * 7U + static_cast<std::uint32_t>(level));
    value += (patch - 0.5F) * (0.45F - 0.1F * static_cast<float>(level)) * resolved(cell_m, point.footprint_m);
  }
  return value;
}

float plain(const Paint& paint) {
  return 0.3F + 0.3F * unit_float(hash_of(paint.seed, 5));
}

}  // namespace

Look interior_look(const Paint& paint, const SurfacePoint& point) {
  switch (paint.material) {
    case Material::kCardboard: return {cardboard(paint, point)};
    case Material::kFloorTiles: return {floor_tiles(point), 0.02F};
    case Material::kPanelWall: return {panel_wall(paint, point)};
    case Material::kPoster: return {poster(paint, point)};
    default: return {plain(paint)};
  }
}

}  // namespace kinetrace::simulator
