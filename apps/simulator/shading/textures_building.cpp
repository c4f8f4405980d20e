// Houses and street furniture. Facades follow uv: metres along the wall and up from its foot.
#include "shading/noise_kernel.hpp"
#include "shading/pattern.hpp"
#include "shading/textures.hpp"

namespace kinetrace::simulator::KINETRACE_KERNEL_ISA {
namespace {

Floats brick_wall(const Points& point) {
  static const Octaves grain(0.6F, 0.8F, 8, 201);
  constexpr float kLength_m = 0.25F;
  constexpr float kCourse_m = 0.083F;
  const Floats width_m = max(point.footprint_m, 0.001F);
  const Floats row = floor_of(point.v / kCourse_m);
  const Floats u = point.u + select(is_even(row), 0.F, 0.5F * kLength_m);
  const Floats mortar =
      1.F - (1.F - stripes(u, kLength_m, 0.012F, width_m)) * (1.F - stripes(point.v, kCourse_m, 0.012F, width_m));
  const Floats brick = cell_value(floor_of(u / kLength_m), row, 202) - 0.5F;
  const Floats stone = 0.21F + 0.16F * brick * resolved(kCourse_m, point.footprint_m) +
                       0.035F * fractal_noise(grain, point.position, point.footprint_m);
  return mix(stone, 0.45F, mortar);
}

Floats plaster(const Paint& paint, const Points& point) {
  static const Octaves stains(1.7F, 0.75F, 8, 203);
  const float base = 0.34F + 0.32F * paint_value(paint.seed, 1);
  // Rain streaks: the same noise, stretched along the wall's height.
  const Vec3 stretched{point.position.x * 4.F, point.position.y * 0.5F, point.position.z * 4.F};
  return base + 0.055F * fractal_noise(stains, point.position, point.footprint_m) +
         0.03F * fractal_noise(stains, stretched, 4.F * point.footprint_m);
}

Floats concrete(const Paint& paint, const Points& point) {
  static const Octaves grain(0.9F, 0.82F, 8, 204);
  return 0.3F + 0.15F * paint_value(paint.seed, 2) + 0.06F * fractal_noise(grain, point.position, point.footprint_m);
}

// A regular grid of windows, in the wall's uv coordinates.
struct WindowGrid {
  float pitch_m;
  float storey_m;
  float wide_m;
  float tall_m;
};

WindowGrid window_grid(const Paint& paint) {
  const float pitch_m = 2.3F + 1.1F * paint_value(paint.seed, 11);
  return {pitch_m, 3.F, 0.42F * pitch_m, 1.5F + 0.3F * paint_value(paint.seed, 12)};
}

// A pane behind its frame and cross bar, with curtains that differ from window to window: `look` where a window is.
Looks window_look(const Paint& paint, const WindowGrid& grid, Floats u, Floats v, Floats footprint_m) {
  constexpr float kFrame_m = 0.06F;
  const Floats width_m = max(footprint_m, 0.002F);
  const Floats column = floor_of(u / grid.pitch_m);
  const Floats row = floor_of(v / grid.storey_m);
  const Floats x = u - column * grid.pitch_m;
  const Floats y = v - row * grid.storey_m;
  const Floats clear =
      band(x, kFrame_m, grid.wide_m - kFrame_m, width_m) * band(y, kFrame_m, grid.tall_m - kFrame_m, width_m);
  const Floats bars = max(band(x, 0.5F * grid.wide_m - 0.025F, 0.5F * grid.wide_m + 0.025F, width_m),
                          band(y, 0.62F * grid.tall_m, 0.62F * grid.tall_m + 0.05F, width_m));
  const Floats glass = clear * (1.F - bars);
  const Floats curtain = cell_value(column, row, paint.seed + 13U);
  const Floats drawn = select(curtain > 0.45F, band(y, curtain * grid.tall_m, grid.tall_m, width_m), 0.F);
  const Floats folds = 0.07F * sin(x * 43.F) * resolved(0.14F, footprint_m);
  const Floats pane = mix(0.035F + 0.05F * curtain, 0.42F + folds, drawn);
  const float frame = paint_value(paint.seed, 14) > 0.4F ? 0.72F : 0.12F;
  return {mix(frame, pane, glass), 0.08F * glass};
}

// A wall with windows; its albedo `wall` is evaluated only where it is visible.
template <typename Wall>
Looks with_windows(const Wall& wall, const Paint& paint, const Points& point) {
  constexpr float kSill_m = 0.85F;
  const WindowGrid grid = window_grid(paint);
  const Floats width_m = max(point.footprint_m, 0.002F);
  const Floats u = point.u - 0.29F * grid.pitch_m;
  const Floats v = point.v - kSill_m;
  const Floats opening =
      stripes(u, grid.pitch_m, grid.wide_m, width_m) * stripes(v, grid.storey_m, grid.tall_m, width_m);
  Looks look{any(opening < 1.F) ? wall() : 0.F};
  if (any(opening > 0.F)) {
    constexpr float kFromAfar = 0.22F;  // Albedo of a window whose parts are not resolved.
    const Floats detail = resolved(0.8F, point.footprint_m);
    const Looks window = any(detail > 0.F) ? window_look(paint, grid, u, v, point.footprint_m) : Looks{};
    look.albedo = mix(look.albedo, mix(kFromAfar, window.albedo, detail), opening);
    look.gloss = window.gloss * detail * opening;
  }
  return look;
}

Floats roof_tiles(const Points& point) {
  static const Octaves moss(0.8F, 0.8F, 7, 205);
  constexpr float kRow_m = 0.33F;
  constexpr float kTile_m = 0.22F;
  const Floats width_m = max(point.footprint_m, 0.002F);
  const Floats row = floor_of(point.v / kRow_m);
  const Floats tile = cell_value(floor_of(point.u / kTile_m), row, 206) - 0.5F;
  const Floats shade = stripes(point.v, kRow_m, 0.05F, width_m);
  const Floats gap = stripes(point.u, kTile_m, 0.03F, width_m);
  return (0.17F + 0.09F * tile * resolved(kTile_m, point.footprint_m) +
          0.03F * fractal_noise(moss, point.position, point.footprint_m)) *
         (1.F - 0.5F * max(shade, 0.6F * gap));
}

Floats metal(const Paint& paint, const Points& point) {
  static const Octaves rust(0.3F, 0.8F, 7, 207);
  return 0.14F + 0.35F * paint_value(paint.seed, 3) + 0.05F * fractal_noise(rust, point.position, point.footprint_m);
}

Floats wood(const Paint& paint, const Points& point) {
  static const Octaves grain(0.25F, 0.8F, 7, 208);
  const Vec3 along{point.position.x * 3.F, point.position.y * 0.3F, point.position.z * 3.F};
  const Floats plank = stripes(point.u, 0.14F, 0.02F, max(point.footprint_m, 0.002F));
  return (0.2F + 0.2F * paint_value(paint.seed, 4) + 0.06F * fractal_noise(grain, along, 3.F * point.footprint_m)) *
         (1.F - 0.75F * plank);
}

// A board with a dark rim and made-up writing.
Floats sign(const Paint& paint, const Points& point) {
  const Floats width_m = max(point.footprint_m, 0.002F);
  constexpr float kGlyph_m = 0.07F;
  const Floats column = floor_of(point.u / kGlyph_m);
  const Floats row = floor_of(point.v / kGlyph_m);
  const Floats inked = select(cell_value(column, row, paint.seed) > 0.5F, 1.F, 0.F);
  const Floats gap = stripes(point.v, 3.F * kGlyph_m, kGlyph_m, width_m);
  const Floats ink =
      inked * resolved(kGlyph_m, point.footprint_m) + 0.5F * (1.F - resolved(kGlyph_m, point.footprint_m));
  return mix(0.75F, 0.1F, 0.9F * ink * (1.F - gap));
}

}  // namespace

Looks building_look(const Paint& paint, const Points& point) {
  switch (paint.material) {
    case Material::kBrickFacade: return with_windows([&] { return brick_wall(point); }, paint, point);
    case Material::kPlasterFacade: return with_windows([&] { return plaster(paint, point); }, paint, point);
    case Material::kRoofTiles: return {roof_tiles(point)};
    case Material::kMetal: return {metal(paint, point), 0.03F};
    case Material::kWood: return {wood(paint, point)};
    case Material::kSign: return {sign(paint, point), 0.02F};
    default: return {concrete(paint, point)};
  }
}

}  // namespace kinetrace::simulator::KINETRACE_KERNEL_ISA
