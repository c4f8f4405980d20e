// Vehicles: paint, glass, lamps, seams and plates, drawn in body coordinates (x forward, y down, z left).
#include "shading/noise_kernel.hpp"
#include "shading/pattern.hpp"
#include "shading/textures.hpp"

namespace kinetrace::simulator::KINETRACE_KERNEL_ISA {
namespace {

constexpr float kTrim = 0.035F;

float paint_albedo(const Paint& paint) {
  if (paint.shape != nullptr && paint.shape->trim.paint >= 0.F) {
    return paint.shape->trim.paint;
  }
  constexpr std::uint32_t kCount = 8;
  constexpr float kTones[kCount] = {0.06F, 0.12F, 0.2F, 0.3F, 0.42F, 0.55F, 0.68F, 0.16F};
  return kTones[hash_of(paint.seed, 1) % kCount];
}

// Common input of the drawing functions: the position on the body, and the width of a pixel there.
struct BodyPoint {
  const BodyShape& shape;
  Floats x;  ///< Forward.
  Floats h;  ///< Above the ground.
  Floats z;  ///< To the left.
  Floats width_m;
};

// Blends `albedo` and `gloss` over the look, by their coverage.
void cover(Looks& look, Floats albedo, Floats gloss, Floats coverage) {
  look.albedo = mix(look.albedo, albedo, coverage);
  look.gloss = mix(look.gloss, gloss, coverage);
}

// x of a pillar's edge at height h, on the line from (foot, belt) to (top, roof).
Floats pillar(const BodyPoint& at, float foot, float top) {
  const Floats rise = (at.h - at.shape.belt_m) / (at.shape.height_m - at.shape.belt_m);
  return mix(foot, top, rise);
}

// A mark and two lines of made-up writing behind the front door.
void draw_print(const BodyPoint& at, std::uint32_t seed, Looks& look) {
  constexpr float kGlyph_m = 0.16F;
  const BodyShape& s = at.shape;
  const Floats mark = disc(length(at.x - s.windscreen_m + 2.1F, at.h - s.belt_m - 0.25F), 0.42F, at.width_m);
  const Floats from = s.windscreen_m - 4.6F;
  const Floats line = band(at.x, from, from + 1.8F, at.width_m) * stripes(at.h - s.belt_m, 0.4F, 0.22F, at.width_m) *
                      band(at.h, s.belt_m - 0.1F, s.belt_m + 0.7F, at.width_m);
  const Floats glyph = cell_value(floor_of(at.x / kGlyph_m), floor_of(at.h / (0.5F * kGlyph_m)), seed);
  const Floats ink = mix(0.5F, select(glyph > 0.45F, 1.F, 0.F), resolved(kGlyph_m, at.width_m));
  cover(look, s.trim.print, s.trim.paint_gloss, max(mark * (0.4F + 0.6F * ink), line * ink));
}

void draw_side(const BodyPoint& at, std::uint32_t paint_seed, Looks& look) {
  const BodyShape& s = at.shape;
  const Floats front = pillar(at, s.windscreen_m, s.windscreen_top_m) - 0.12F;
  const Floats rear =
      s.has_rear_side_windows ? pillar(at, s.rear_window_m, s.rear_window_top_m) + 0.22F : s.windscreen_m - 1.25F;
  const Floats rows = band(at.h, s.belt_m + 0.03F, s.height_m - 0.1F, at.width_m);
  const Floats columns = band(at.x, rear, front, at.width_m);
  const float door_x = s.windscreen_m - 1.25F;
  Floats frame = 0.F;
  for (int i = 0; i < s.trim.pillars; ++i) {
    const float x = door_x - s.trim.pillar_pitch_m * static_cast<float>(i);
    frame = max(frame, band(at.x, x - 0.05F, x + 0.05F, at.width_m));
  }
  cover(look, kTrim, s.trim.paint_gloss,
        band(at.h, s.belt_m, s.height_m - 0.07F, at.width_m) * band(at.x, rear - 0.03F, front + 0.03F, at.width_m) *
            0.8F);
  cover(look, s.trim.glass, s.trim.glass_gloss, rows * columns * (1.F - frame));
  // Seams of the doors, handles, a rubbing strip and the dark sill.
  const Floats doors = band(at.h, s.trim.sill_m, s.belt_m, at.width_m);
  const Floats second_door = s.has_rear_side_windows ? band(at.x, door_x - 1.03F, door_x - 1.015F, at.width_m) : 0.F;
  const Floats seams = band(at.x, door_x - 0.008F, door_x + 0.008F, at.width_m) + second_door +
                       band(at.x, s.windscreen_m - 0.06F, s.windscreen_m - 0.045F, at.width_m);
  cover(look, kTrim, 0.F, 0.85F * doors * min(seams, 1.F));
  const Floats handles =
      band(at.h, s.belt_m - 0.13F, s.belt_m - 0.1F, at.width_m) *
      (band(at.x, door_x + 0.06F, door_x + 0.24F, at.width_m) + band(at.x, door_x - 0.95F, door_x - 0.77F, at.width_m));
  cover(look, 0.03F + select(look.albedo < 0.25F, 0.4F, 0.F), s.trim.paint_gloss, min(handles, 1.F));
  cover(look, look.albedo * 0.5F, 0.02F, band(at.h, s.trim.strip_m, s.trim.strip_m + 0.04F, at.width_m));
  cover(look, kTrim, 0.F, band(at.h, 0.F, s.trim.sill_m, at.width_m));
  if (s.trim.print >= 0.F) {
    draw_print(at, paint_seed, look);
  }
  const float axles[] = {s.front_axle_m, s.rear_axle_m};
  for (const float axle : axles) {
    cover(look, 0.015F, 0.F, disc(length(at.x - axle, at.h - s.wheel_radius_m), s.wheel_radius_m + 0.06F, at.width_m));
  }
}

void draw_plate(const BodyPoint& at, float low_m, std::uint32_t seed, Looks& look) {
  const Floats plate = band(at.z, -0.26F, 0.26F, at.width_m) * band(at.h, low_m, low_m + 0.11F, at.width_m);
  const Floats glyph = cell_value(floor_of((at.z + 0.26F) / 0.032F), floor_of((at.h - low_m) / 0.027F), seed);
  const Floats ink = mix(0.4F, select(glyph > 0.5F, 1.F, 0.F), resolved(0.03F, at.width_m)) *
                     band(at.z, -0.23F, 0.23F, at.width_m) * band(at.h, low_m + 0.02F, low_m + 0.09F, at.width_m);
  cover(look, 0.8F, 0.F, plate);
  cover(look, 0.06F, 0.F, plate * ink);
}

void draw_end_glass(const BodyPoint& at, Looks& look) {
  const Floats narrowing = 0.13F * (at.h - at.shape.belt_m);
  const Floats half = 0.5F * at.shape.width_m - 0.16F - narrowing;
  const Floats glass =
      band(at.z, -half, half, at.width_m) * band(at.h, at.shape.belt_m + 0.05F, at.shape.height_m - 0.06F, at.width_m);
  cover(look, at.shape.trim.glass, at.shape.trim.glass_gloss, glass);
}

void draw_front(const BodyPoint& at, std::uint32_t seed, Looks& look) {
  const BodyTrim& trim = at.shape.trim;
  const float half = 0.5F * at.shape.width_m;
  draw_end_glass(at, look);
  const Floats grille = band(at.z, -trim.grille_half * half, trim.grille_half * half, at.width_m) *
                        band(at.h, trim.grille_low_m, trim.grille_high_m, at.width_m);
  cover(look, mix(0.02F, 0.3F, stripes(at.h, 0.04F, 0.012F, at.width_m)), 0.02F, grille);
  const Floats intake = band(at.z, -0.7F * half, 0.7F * half, at.width_m) * band(at.h, 0.25F, 0.36F, at.width_m);
  cover(look, 0.02F, 0.F, intake);
  const Floats side = abs(at.z) - trim.headlamp_out * half;
  const Floats lamp =
      disc(length(side, trim.headlamp_squeeze * (at.h - trim.headlamp_m)), trim.headlamp_radius_m, at.width_m);
  const Floats bulb = disc(length(side, at.h - trim.headlamp_m), 0.06F, at.width_m);
  cover(look, 0.45F, 0.15F, lamp);
  cover(look, 0.9F, 0.2F, bulb);
  draw_plate(at, trim.plate_front_m, hash_of(seed, 2), look);
}

void draw_rear(const BodyPoint& at, std::uint32_t seed, Looks& look) {
  const BodyTrim& trim = at.shape.trim;
  const float half = 0.5F * at.shape.width_m;
  if (trim.has_rear_window) {
    draw_end_glass(at, look);
  }
  const Floats outer = band(abs(at.z), trim.rear_lamp_out * half, half, at.width_m);
  const Floats lamp = outer * band(at.h, trim.rear_lamp_low_m, trim.rear_lamp_high_m, at.width_m);
  cover(look, select(look.albedo > 0.25F, 0.07F, 0.3F), 0.06F, lamp);
  cover(look, 0.75F, 0.06F, lamp * band(at.h, trim.rear_lamp_low_m + 0.07F, trim.rear_lamp_low_m + 0.14F, at.width_m));
  cover(look, kTrim, 0.02F, band(at.h, 0.F, 0.34F, at.width_m));
  cover(look, kTrim, 0.F, band(at.h, 0.6F, 0.612F, at.width_m));
  const Floats badge = disc(length(at.z, at.h - 0.76F), 0.05F, at.width_m);
  cover(look, 0.6F, 0.2F, badge);
  draw_plate(at, trim.plate_rear_m, hash_of(seed, 2), look);
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
  Looks look{paint_albedo(paint) * (1.F + soiled * soil), paint.shape->trim.paint_gloss};
  const Floats end = abs(point.normal.x);
  const Mask on_side = abs(point.normal.z) > max(end, 0.45F);
  const Mask on_end = (end > 0.28F) & !on_side;
  draw_where(on_side, look, [&](Looks& drawn) { draw_side(at, paint.seed, drawn); });
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

// Tyres and plain rims look the same at every angle of the wheel's turn; those of other seeds have spokes.
Looks rim(const Paint& paint, const Points& point) {
  const Floats width_m = max(point.footprint_m, 0.001F);
  const Floats r = length(point.u, point.v);
  const Floats hub = disc(r, 0.05F, width_m);
  const Floats dish = disc(r, 0.17F, width_m) - disc(r, 0.1F, width_m);
  if (paint.seed == 0) {
    return {0.42F - 0.34F * dish + 0.2F * hub, 0.08F};
  }
  const float count = 5.F + static_cast<float>(hash_of(paint.seed, 4) % 6);
  const Floats spokes = soft_step(-0.4F, 0.4F, sin(count * atan2(point.u, point.v) + paint_value(paint.seed, 5)));
  const Floats open = (disc(r, 0.16F + 0.06F * paint_value(paint.seed, 6), width_m) - disc(r, 0.05F, width_m)) * spokes;
  return {(0.08F + 0.5F * paint_value(paint.seed, 7)) * (1.F - 0.85F * open), 0.08F};
}

}  // namespace

Looks vehicle_look(const Paint& paint, const Points& point) {
  switch (paint.material) {
    case Material::kTruckBox: return truck_box(paint, point);
    case Material::kTyre: return {0.035F};
    case Material::kRim: return rim(paint, point);
    case Material::kMirror: return {0.5F * paint_albedo(paint), 0.05F};
    default: return car_body(paint, point);
  }
}

}  // namespace kinetrace::simulator::KINETRACE_KERNEL_ISA
