// Rooms and their furniture; also the plain surface of the textureless scene.
#include "shading/noise_kernel.hpp"
#include "shading/pattern.hpp"
#include "shading/textures.hpp"

namespace kinetrace::simulator::KINETRACE_KERNEL_ISA {
namespace {

Floats cardboard(const Paint& paint, const Points& point) {
  static const Octaves fibre(0.2F, 0.85F, 7, 601);
  const Floats width_m = max(point.footprint_m, 0.001F);
  const Floats tape = band(point.u, 0.2F, 0.25F, width_m);
  const Floats label = band(point.u, 0.05F, 0.17F, width_m) * band(point.v, 0.08F, 0.2F, width_m);
  const Floats writing = cell_value(floor_of(point.u / 0.012F), floor_of(point.v / 0.016F), paint.seed);
  const Floats ink = mix(0.5F, select(writing > 0.55F, 1.F, 0.F), resolved(0.012F, point.footprint_m));
  const Floats paper =
      0.3F + 0.12F * paint_value(paint.seed, 1) + 0.035F * fractal_noise(fibre, point.position, point.footprint_m);
  return mix(mix(paper, 0.5F, tape), mix(0.8F, 0.1F, ink), label);
}

Floats floor_tiles(const Points& point) {
  static const Octaves marble(0.5F, 0.93F, 8, 602);
  constexpr float kTile_m = 0.4F;
  const Floats width_m = max(point.footprint_m, 0.001F);
  const Floats x = point.position.x;
  const Floats z = point.position.z;
  const Floats joints =
      1.F - (1.F - stripes(x, kTile_m, 0.006F, width_m)) * (1.F - stripes(z, kTile_m, 0.006F, width_m));
  const Floats tile = cell_value(floor_of(x / kTile_m), floor_of(z / kTile_m), 603) - 0.5F;
  return (0.36F + 0.1F * tile * resolved(kTile_m, point.footprint_m) +
          0.07F * fractal_noise(marble, point.position, point.footprint_m)) *
         (1.F - 0.5F * joints);
}

Floats panel_wall(const Paint& paint, const Points& point) {
  static const Octaves roughcast(0.4F, 0.93F, 8, 604);
  const Floats width_m = max(point.footprint_m, 0.001F);
  const Floats joints = stripes(point.u, 1.2F, 0.01F, width_m);
  const Floats skirting = band(point.v, 0.F, 0.1F, width_m);
  const float base = 0.45F + 0.15F * paint_value(paint.seed, 1);
  return mix(base + 0.06F * fractal_noise(roughcast, point.position, point.footprint_m), 0.16F,
             max(0.6F * joints, skirting));
}

// A picture: patches of several sizes, as in prints, books and notices.
Floats poster(const Paint& paint, const Points& point) {
  static const Octaves ink(0.3F, 0.75F, 7, 605);
  Floats value = 0.4F + 0.07F * fractal_noise(ink, point.position, point.footprint_m);
  for (int level = 0; level < 3; ++level) {
    const float cell_m = 0.24F / static_cast<float>(1 << level);
    const Floats patch = cell_value(floor_of(point.u / cell_m), floor_of(point.v / cell_m),
                                    paint.seed * 7U + static_cast<std::uint32_t>(level));
    value = value + (patch - 0.5F) * (0.45F - 0.1F * static_cast<float>(level)) * resolved(cell_m, point.footprint_m);
  }
  return value;
}

Floats plain(const Paint& paint) {
  return 0.3F + 0.3F * paint_value(paint.seed, 5);
}

}  // namespace

Looks interior_look(const Paint& paint, const Points& point) {
  switch (paint.material) {
    case Material::kCardboard: return {cardboard(paint, point)};
    case Material::kFloorTiles: return {floor_tiles(point), 0.02F};
    case Material::kPanelWall: return {panel_wall(paint, point)};
    case Material::kPoster: return {poster(paint, point)};
    default: return {plain(paint)};
  }
}

}  // namespace kinetrace::simulator::KINETRACE_KERNEL_ISA
