// Vehicles: paint, glass, lamps, seams and plates, drawn in body coordinates (x forward, y down, z left).
#include <algorithm>
#include <array>
#include <cmath>

#include "noise.hpp"
#include "pattern.hpp"
#include "textures.hpp"

namespace kinetrace::simulator {
namespace {

constexpr float kGlassGloss = 0.055F;
constexpr float kPaintGloss = 0.05F;
constexpr float kGlass = 0.02F;
constexpr float kTrim = 0.035F;

float paint_albedo(const Paint& paint) {
  constexpr std::array<float, 8> kTones{0.06F, 0.12F, 0.2F, 0.3F, 0.42F, 0.55F, 0.68F, 0.16F};
  return kTones[hash_of(paint.seed, 1) % kTones.size()];
}

// What the drawing functions below share: where we are on the body, and how wide a pixel is there.
struct BodyPoint {
  const BodyShape& shape;
  float x;  ///< Forward.
  float h;  ///< Above the ground.
  float z;  ///< To the left.
  float width_m;
};

// How much `value` covers the look so far.
void cover(Look& look, float albedo, float gloss, float coverage) {
  look.albedo = mix(look.albedo, albedo, coverage);
  look.gloss = mix(look.gloss, gloss, coverage);
}

// x of a pillar's edge at height h, on the line from (foot, belt) to (top, roof).
float pillar(const BodyPoint& at, float foot, float top) {
  const float rise = (at.h - at.shape.belt_m) / (at.shape.height_m - at.shape.belt_m);
  return mix(foot, top, rise);
}

void draw_side(const BodyPoint& at, Look& look) {
  const BodyShape& s = at.shape;
  const float front = pillar(at, s.windscreen_m, s.windscreen_top_m) - 0.12F;
  const float rear =
      s.has_rear_side_windows ? pillar(at, s.rear_window_m, s.rear_window_top_m) + 0.22F : s.windscreen_m - 1.25F;
  const float rows = band(at.h, s.belt_m + 0.03F, s.height_m - 0.1F, at.width_m);
  const float columns = band(at.x, rear, front, at.width_m);
  const float door_x = s.windscreen_m - 1.25F;
  const float frame = band(at.x, door_x - 0.05F, door_x + 0.05F, at.width_m);
  cover(look, kTrim, kPaintGloss,
        band(at.h, s.belt_m, s.height_m - 0.07F, at.width_m) * band(at.x, rear - 0.03F, front + 0.03F, at.width_m) *
            0.8F);
  cover(look, kGlass, kGlassGloss, rows * columns * (1.F - frame));
  // Seams of the doors, handles, a rubbing strip and the dark sill.
  const float doors = band(at.h, 0.3F, s.belt_m, at.width_m);
  const float second_door = s.has_rear_side_windows ? band(at.x, door_x - 1.03F, door_x - 1.015F, at.width_m) : 0.F;
  const float seams = band(at.x, door_x - 0.008F, door_x + 0.008F, at.width_m) + second_door +
                      band(at.x, s.windscreen_m - 0.06F, s.windscreen_m - 0.045F, at.width_m);
  cover(look, kTrim, 0.F, 0.85F * doors * std::min(seams, 1.F));
  const float handles =
      band(at.h, s.belt_m - 0.13F, s.belt_m - 0.1F, at.width_m) *
      (band(at.x, door_x + 0.06F, door_x + 0.24F, at.width_m) + band(at.x, door_x - 0.95F, door_x - 0.77F, at.width_m));
  cover(look, 0.03F + 0.4F * (look.albedo < 0.25F ? 1.F : 0.F), kPaintGloss, std::min(handles, 1.F));
  cover(look, look.albedo * 0.5F, 0.02F, band(at.h, 0.52F, 0.56F, at.width_m));
  cover(look, kTrim, 0.F, band(at.h, 0.F, 0.3F, at.width_m));
  for (const float axle : {s.front_axle_m, s.rear_axle_m}) {
    cover(look, 0.015F, 0.F,
          disc(std::hypot(at.x - axle, at.h - s.wheel_radius_m), s.wheel_radius_m + 0.06F, at.width_m));
  }
}

void draw_plate(const BodyPoint& at, std::uint32_t seed, Look& look) {
  constexpr float kLow_m = 0.42F;
  const float plate = band(at.z, -0.26F, 0.26F, at.width_m) * band(at.h, kLow_m, kLow_m + 0.11F, at.width_m);
  const float glyph = cell_value(floor_of((at.z + 0.26F) / 0.032F), floor_of((at.h - kLow_m) / 0.027F), seed);
  const float ink = mix(0.4F, glyph > 0.5F ? 1.F : 0.F, resolved(0.03F, at.width_m)) *
                    band(at.z, -0.23F, 0.23F, at.width_m) * band(at.h, kLow_m + 0.02F, kLow_m + 0.09F, at.width_m);
  cover(look, 0.8F, 0.F, plate);
  cover(look, 0.06F, 0.F, plate * ink);
}

void draw_end_glass(const BodyPoint& at, Look& look) {
  const float narrowing = 0.13F * (at.h - at.shape.belt_m);
  const float half = 0.5F * at.shape.width_m - 0.16F - narrowing;
  const float glass =
      band(at.z, -half, half, at.width_m) * band(at.h, at.shape.belt_m + 0.05F, at.shape.height_m - 0.06F, at.width_m);
  cover(look, kGlass, kGlassGloss, glass);
}

void draw_front(const BodyPoint& at, std::uint32_t seed, Look& look) {
  const float half = 0.5F * at.shape.width_m;
  draw_end_glass(at, look);
  const float grille = band(at.z, -0.45F * half, 0.45F * half, at.width_m) * band(at.h, 0.55F, 0.72F, at.width_m);
  cover(look, mix(0.02F, 0.3F, stripes(at.h, 0.04F, 0.012F, at.width_m)), 0.02F, grille);
  const float intake = band(at.z, -0.7F * half, 0.7F * half, at.width_m) * band(at.h, 0.25F, 0.36F, at.width_m);
  cover(look, 0.02F, 0.F, intake);
  const float side = std::abs(at.z) - 0.72F * half;
  const float lamp = disc(std::hypot(side, 1.7F * (at.h - 0.66F)), 0.17F, at.width_m);
  const float bulb = disc(std::hypot(side, at.h - 0.66F), 0.06F, at.width_m);
  cover(look, 0.45F, 0.15F, lamp);
  cover(look, 0.9F, 0.2F, bulb);
  draw_plate(at, hash_of(seed, 2), look);
}

void draw_rear(const BodyPoint& at, std::uint32_t seed, Look& look) {
  const float half = 0.5F * at.shape.width_m;
  draw_end_glass(at, look);
  const float outer = band(std::abs(at.z), 0.58F * half, half, at.width_m);
  const float lamp = outer * band(at.h, 0.64F, 0.88F, at.width_m);
  cover(look, look.albedo > 0.25F ? 0.07F : 0.3F, 0.06F, lamp);
  cover(look, 0.75F, 0.06F, lamp * band(at.h, 0.71F, 0.78F, at.width_m));
  cover(look, kTrim, 0.02F, band(at.h, 0.F, 0.34F, at.width_m));
  cover(look, kTrim, 0.F, band(at.h, 0.6F, 0.612F, at.width_m));
  const float badge = disc(std::hypot(at.z, at.h - 0.76F), 0.05F, at.width_m);
  cover(look, 0.6F, 0.2F, badge);
  draw_plate(at, hash_of(seed, 2), look);
}

Look car_body(const Paint& paint, const SurfacePoint& point) {
  static const Octaves dirt(0.7F, 0.75F, 7, 401);
  const BodyPoint at{*paint.shape, point.position.x() - paint.shape->origin_x_m, -point.position.y(),
                     point.position.z(), std::max(point.footprint_m, 0.001F)};
  const float soil = fractal_noise(dirt, point.position, point.footprint_m);
  // Road dirt: hardly anything on the roof, more towards the sills.
  const float soiled = 0.03F + 0.09F * soft_step(0.8F, 0.2F, at.h);
  Look look{paint_albedo(paint) * (1.F + soiled * soil), kPaintGloss};
  const float end = std::abs(point.normal.x());
  if (std::abs(point.normal.z()) > std::max(end, 0.45F)) {
    draw_side(at, look);
  } else if (end > 0.28F && at.x > 0.F) {
    draw_front(at, paint.seed, look);
  } else if (end > 0.28F) {
    draw_rear(at, paint.seed, look);
  }
  return look;
}

// The box of a truck: ribbed sheet with a large print.
Look truck_box(const Paint& paint, const SurfacePoint& point) {
  static const Octaves print(0.9F, 0.72F, 7, 402);
  const float width_m = std::max(point.footprint_m, 0.001F);
  const float ribs = stripes(point.uv.x(), 0.5F, 0.02F, width_m);
  const float picture = fractal_noise(print, point.position, point.footprint_m);
  const float inside = band(point.uv.y(), 0.4F, 1.7F, width_m);
  const float base = 0.35F + 0.3F * unit_float(hash_of(paint.seed, 3));
  return {
      mix(base, base * 0.45F, inside * soft_step(0.F, 0.25F, picture)) * (1.F + 0.05F * picture) * (1.F - 0.4F * ribs),
      0.03F};
}

// Tyres and rims look the same at every angle of the wheel's turn.
Look rim(const SurfacePoint& point) {
  const float width_m = std::max(point.footprint_m, 0.001F);
  const float r = point.uv.norm();
  const float hub = disc(r, 0.05F, width_m);
  const float dish = disc(r, 0.17F, width_m) - disc(r, 0.1F, width_m);
  return {0.42F - 0.34F * dish + 0.2F * hub, 0.08F};
}

}  // namespace

Look vehicle_look(const Paint& paint, const SurfacePoint& point) {
  switch (paint.material) {
    case Material::kTruckBox: return truck_box(paint, point);
    case Material::kTyre: return {0.035F};
    case Material::kRim: return rim(point);
    case Material::kMirror: return {0.5F * paint_albedo(paint), kPaintGloss};
    default: return car_body(paint, point);
  }
}

}  // namespace kinetrace::simulator
