// Vehicles: paint, glass, lamps, seams and plates, drawn in body coordinates (x forward, y down, z left).
#include "noise_kernel.hpp"
#include "pattern.hpp"
#include "textures.hpp"

namespace kinetrace::simulator::KINETRACE_KERNEL_ISA {
namespace {

constexpr float kGlassGloss = 0.055F;
constexpr float kPaintGloss = 0.05F;
constexpr float kGlass = 0.02F;
constexpr float kTrim = 0.035F;

float paint_albedo(const Paint& paint) {
  constexpr std::uint32_t kCount = 8;
  constexpr float kTones[kCount] = {0.06F, 0.12F, 0.2F, 0.3F, 0.42F, 0.55F, 0.68F, 0.16F};
  return kTones[hash_of(paint.seed, 1) % kCount];
}

// What the drawing functions below share: where we are on the body, and how wide a pixel is there.
struct BodyPoint {
  const BodyShape& shape;
  Floats x;  ///< Forward.
  Floats h;  ///< Above the ground.
  Floats z;  ///< To the left.
  Floats width_m;
};

// How much `value` covers the look so far.
void cover(Looks& look, Floats albedo, Floats gloss, Floats coverage) {
  look.albedo = mix(look.albedo, albedo, coverage);
  look.gloss = mix(look.gloss, gloss, coverage);
}

// x of a pillar's edge at height h, on the line from (foot, belt) to (top, roof).
Floats pillar(const BodyPoint& at, float foot, float top) {
  const Floats rise = (at.h - at.shape.belt_m) / (at.shape.height_m - at.shape.belt_m);
  return mix(foot, top, rise);
}

void draw_side(const BodyPoint& at, Looks& look) {
  const BodyShape& s = at.shape;
  const Floats front = pillar(at, s.windscreen_m, s.windscreen_top_m) - 0.12F;
  const Floats rear =
      s.has_rear_side_windows ? pillar(at, s.rear_window_m, s.rear_window_top_m) + 0.22F : s.windscreen_m - 1.25F;
  const Floats rows = band(at.h, s.belt_m + 0.03F, s.height_m - 0.1F, at.width_m);
  const Floats columns = band(at.x, rear, front, at.width_m);
  const float door_x = s.windscreen_m - 1.25F;
  const Floats frame = band(at.x, door_x - 0.05F, door_x + 0.05F, at.width_m);
  cover(look, kTrim, kPaintGloss,
        band(at.h, s.belt_m, s.height_m - 0.07F, at.width_m) * band(at.x, rear - 0.03F, front + 0.03F, at.width_m) *
            0.8F);
  cover(look, kGlass, kGlassGloss, rows * columns * (1.F - frame));
  // Seams of the doors, handles, a rubbing strip and the dark sill.
  const Floats doors = band(at.h, 0.3F, s.belt_m, at.width_m);
  const Floats second_door = s.has_rear_side_windows ? band(at.x, door_x - 1.03F, door_x - 1.015F, at.width_m) : 0.F;
  const Floats seams = band(at.x, door_x - 0.008F, door_x + 0.008F, at.width_m) + second_door +
                       band(at.x, s.windscreen_m - 0.06F, s.windscreen_m - 0.045F, at.width_m);
  cover(look, kTrim, 0.F, 0.85F * doors * min(seams, 1.F));
  const Floats handles =
      band(at.h, s.belt_m - 0.13F, s.belt_m - 0.1F, at.width_m) *
      (band(at.x, door_x + 0.06F, door_x + 0.24F, at.width_m) + band(at.x, door_x - 0.95F, door_x - 0.77F, at.width_m));
  cover(look, 0.03F + select(look.albedo < 0.25F, 0.4F, 0.F), kPaintGloss, min(handles, 1.F));
  cover(look, look.albedo * 0.5F, 0.02F, band(at.h, 0.52F, 0.56F, at.width_m));
  cover(look, kTrim, 0.F, band(at.h, 0.F, 0.3F, at.width_m));
  const float axles[] = {s.front_axle_m, s.rear_axle_m};
  for (const float axle : axles) {
    cover(look, 0.015F, 0.F, disc(length(at.x - axle, at.h - s.wheel_radius_m), s.wheel_radius_m + 0.06F, at.width_m));
  }
}

void draw_plate(const BodyPoint& at, std::uint32_t seed, Looks& look) {
  constexpr float kLow_m = 0.42F;
  const Floats plate = band(at.z, -0.26F, 0.26F, at.width_m) * band(at.h, kLow_m, kLow_m + 0.11F, at.width_m);
  const Floats glyph = cell_value(floor_of((at.z + 0.26F) / 0.032F), floor_of((at.h - kLow_m) / 0.027F), seed);
  const Floats ink = mix(0.4F, select(glyph > 0.5F, 1.F, 0.F), resolved(0.03F, at.width_m)) *
                     band(at.z, -0.23F, 0.23F, at.width_m) * band(at.h, kLow_m + 0.02F, kLow_m + 0.09F, at.width_m);
  cover(look, 0.8F, 0.F, plate);
  cover(look, 0.06F, 0.F, plate * ink);
}

void draw_end_glass(const BodyPoint& at, Looks& look) {
  const Floats narrowing = 0.13F * (at.h - at.shape.belt_m);
  const Floats half = 0.5F * at.shape.width_m - 0.16F - narrowing;
  const Floats glass =
      band(at.z, -half, half, at.width_m) * band(at.h, at.shape.belt_m + 0.05F, at.shape.height_m - 0.06F, at.width_m);
  cover(look, kGlass, kGlassGloss, glass);
}

void draw_front(const BodyPoint& at, std::uint32_t seed, Looks& look) {
  const float half = 0.5F * at.shape.width_m;
  draw_end_glass(at, look);
  const Floats grille = band(at.z, -0.45F * half, 0.45F * half, at.width_m) * band(at.h, 0.55F, 0.72F, at.width_m);
  cover(look, mix(0.02F, 0.3F, stripes(at.h, 0.04F, 0.012F, at.width_m)), 0.02F, grille);
  const Floats intake = band(at.z, -0.7F * half, 0.7F * half, at.width_m) * band(at.h, 0.25F, 0.36F, at.width_m);
  cover(look, 0.02F, 0.F, intake);
  const Floats side = abs(at.z) - 0.72F * half;
  const Floats lamp = disc(length(side, 1.7F * (at.h - 0.66F)), 0.17F, at.width_m);
  const Floats bulb = disc(length(side, at.h - 0.66F), 0.06F, at.width_m);
  cover(look, 0.45F, 0.15F, lamp);
  cover(look, 0.9F, 0.2F, bulb);
  draw_plate(at, hash_of(seed, 2), look);
}

void draw_rear(const BodyPoint& at, std::uint32_t seed, Looks& look) {
  const float half = 0.5F * at.shape.width_m;
  draw_end_glass(at, look);
  const Floats outer = band(abs(at.z), 0.58F * half, half, at.width_m);
  const Floats lamp = outer * band(at.h, 0.64F, 0.88F, at.width_m);
  cover(look, select(look.albedo > 0.25F, 0.07F, 0.3F), 0.06F, lamp);
  cover(look, 0.75F, 0.06F, lamp * band(at.h, 0.71F, 0.78F, at.width_m));
  cover(look, kTrim, 0.02F, band(at.h, 0.F, 0.34F, at.width_m));
  cover(look, kTrim, 0.F, band(at.h, 0.6F, 0.612F, at.width_m));
  const Floats badge = disc(length(at.z, at.h - 0.76F), 0.05F, at.width_m);
  cover(look, 0.6F, 0.2F, badge);
  draw_plate(at, hash_of(seed, 2), look);
}

// Draws on some of the points.
template <typename Draw>
void draw_where(Mask mask, Looks& look, const Draw& draw) {
  if (any(mask)) {
    Looks drawn = look;
    draw(drawn);
    look = {select(mask, drawn.albedo, look.albedo), select(mask, drawn.gloss, look.gloss)};
  }
}

Looks car_body(const Paint& paint, const Points& point) {
  static const Octaves dirt(0.7F, 0.75F, 7, 401);
  const BodyPoint at{*paint.shape, point.position.x - paint.shape->origin_x_m, -point.position.y, point.position.z,
                     max(point.footprint_m, 0.001F)};
  const Floats soil = fractal_noise(dirt, point.position, point.footprint_m);
  // Road dirt: hardly anything on the roof, more towards the sills.
  const Floats soiled = 0.03F + 0.09F * soft_step(0.8F, 0.2F, at.h);
  Looks look{paint_albedo(paint) * (1.F + soiled * soil), kPaintGloss};
  const Floats end = abs(point.normal.x);
  const Mask on_side = abs(point.normal.z) > max(end, 0.45F);
  const Mask on_end = (end > 0.28F) & !on_side;
  draw_where(on_side, look, [&](Looks& drawn) { draw_side(at, drawn); });
  draw_where(on_end & (at.x > 0.F), look, [&](Looks& drawn) { draw_front(at, paint.seed, drawn); });
  draw_where(on_end & !(at.x > 0.F), look, [&](Looks& drawn) { draw_rear(at, paint.seed, drawn); });
  return look;
}

// The box of a truck: ribbed sheet with a large print.
Looks truck_box(const Paint& paint, const Points& point) {
  static const Octaves print(0.9F, 0.72F, 7, 402);
  const Floats width_m = max(point.footprint_m, 0.001F);
  const Floats ribs = stripes(point.u, 0.5F, 0.02F, width_m);
  const Floats picture = fractal_noise(print, point.position, point.footprint_m);
  const Floats inside = band(point.v, 0.4F, 1.7F, width_m);
  const Floats base = 0.35F + 0.3F * paint_value(paint.seed, 3);
  return {
      mix(base, base * 0.45F, inside * soft_step(0.F, 0.25F, picture)) * (1.F + 0.05F * picture) * (1.F - 0.4F * ribs),
      0.03F};
}

// Tyres and rims look the same at every angle of the wheel's turn.
Looks rim(const Points& point) {
  const Floats width_m = max(point.footprint_m, 0.001F);
  const Floats r = length(point.u, point.v);
  const Floats hub = disc(r, 0.05F, width_m);
  const Floats dish = disc(r, 0.17F, width_m) - disc(r, 0.1F, width_m);
  return {0.42F - 0.34F * dish + 0.2F * hub, 0.08F};
}

}  // namespace

Looks vehicle_look(const Paint& paint, const Points& point) {
  switch (paint.material) {
    case Material::kTruckBox: return truck_box(paint, point);
    case Material::kTyre: return {0.035F};
    case Material::kRim: return rim(point);
    case Material::kMirror: return {0.5F * paint_albedo(paint), kPaintGloss};
    default: return car_body(paint, point);
  }
}

}  // namespace kinetrace::simulator::KINETRACE_KERNEL_ISA
