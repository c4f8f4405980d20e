#include "world/random_vehicle.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

namespace kinetrace::simulator {
namespace {

using Eigen::Vector3f;

struct Range {
  float low;
  float high;
};

// Ranges of a make's dimensions.
struct Make {
  double share;  ///< Of all vehicles; the shares add up to 1.
  Range length_m;
  Range height_m;
  Range width_m;
  Range belt;         ///< Height where the windows begin, relative to the vehicle's.
  Range bonnet_rear;  ///< Height of the bonnet before the windscreen, relative to the vehicle's.
  Range bonnet_front;
  Range bonnet;        ///< Relative to the vehicle's length.
  Range windscreen_m;  ///< Horizontal distance of its top behind its foot.
  Range boot;          ///< Relative to the vehicle's length.
  Range deck;          ///< Height of the boot's lid or the bed, relative to the vehicle's.
  Range rear_window_m;
  Range wheel_m;  ///< Radius.
  Range lean;     ///< Of the side windows.
  Range rounding;
  double rear_side_windows;  ///< Probability of having them.
  int pillars;
};

constexpr std::array<Make, 10> kMakes{{
    // Small cars.
    {0.24,
     {3.3F, 4.4F},
     {1.38F, 1.6F},
     {1.58F, 1.84F},
     {0.6F, 0.68F},
     {0.6F, 0.7F},
     {0.44F, 0.56F},
     {0.17F, 0.28F},
     {0.6F, 1.05F},
     {0.F, 0.02F},
     {0.66F, 0.72F},
     {0.2F, 0.7F},
     {0.27F, 0.34F},
     {0.16F, 0.3F},
     {0.12F, 0.22F},
     0.95,
     2},
    // Saloons.
    {0.15,
     {4.2F, 5.2F},
     {1.36F, 1.5F},
     {1.68F, 1.92F},
     {0.62F, 0.69F},
     {0.63F, 0.7F},
     {0.48F, 0.57F},
     {0.22F, 0.29F},
     {0.65F, 1.05F},
     {0.13F, 0.22F},
     {0.64F, 0.74F},
     {0.45F, 1.F},
     {0.29F, 0.35F},
     {0.18F, 0.3F},
     {0.12F, 0.2F},
     1.0,
     2},
    // Estates.
    {0.13,
     {4.2F, 5.F},
     {1.4F, 1.58F},
     {1.68F, 1.92F},
     {0.61F, 0.68F},
     {0.62F, 0.7F},
     {0.48F, 0.56F},
     {0.21F, 0.28F},
     {0.65F, 1.F},
     {0.F, 0.015F},
     {0.66F, 0.7F},
     {0.12F, 0.6F},
     {0.29F, 0.35F},
     {0.16F, 0.28F},
     {0.1F, 0.18F},
     1.0,
     3},
    // Coupes and open ones with their roof up.
    {0.06,
     {3.8F, 4.7F},
     {1.22F, 1.4F},
     {1.65F, 1.88F},
     {0.64F, 0.71F},
     {0.64F, 0.72F},
     {0.46F, 0.58F},
     {0.26F, 0.36F},
     {0.6F, 1.F},
     {0.1F, 0.22F},
     {0.66F, 0.76F},
     {0.6F, 1.2F},
     {0.29F, 0.35F},
     {0.2F, 0.32F},
     {0.12F, 0.24F},
     0.8,
     1},
    // Off-roaders.
    {0.11,
     {3.9F, 5.F},
     {1.58F, 1.95F},
     {1.72F, 2.F},
     {0.57F, 0.65F},
     {0.58F, 0.67F},
     {0.5F, 0.62F},
     {0.19F, 0.27F},
     {0.35F, 0.85F},
     {0.F, 0.015F},
     {0.6F, 0.66F},
     {0.08F, 0.5F},
     {0.33F, 0.41F},
     {0.12F, 0.24F},
     {0.08F, 0.18F},
     1.0,
     3},
    // People carriers.
    {0.09,
     {3.9F, 4.9F},
     {1.56F, 1.9F},
     {1.66F, 1.92F},
     {0.54F, 0.62F},
     {0.56F, 0.64F},
     {0.42F, 0.52F},
     {0.12F, 0.21F},
     {0.7F, 1.3F},
     {0.F, 0.015F},
     {0.6F, 0.65F},
     {0.1F, 0.45F},
     {0.28F, 0.34F},
     {0.12F, 0.24F},
     {0.1F, 0.18F},
     1.0,
     3},
    // Vans.
    {0.1,
     {4.1F, 6.8F},
     {1.75F, 2.8F},
     {1.75F, 2.1F},
     {0.48F, 0.6F},
     {0.44F, 0.58F},
     {0.34F, 0.46F},
     {0.08F, 0.2F},
     {0.4F, 1.F},
     {0.F, 0.01F},
     {0.6F, 0.7F},
     {0.F, 0.15F},
     {0.31F, 0.38F},
     {0.05F, 0.16F},
     {0.04F, 0.12F},
     0.3,
     3},
    // Delivery vans with an upright front.
    {0.04,
     {5.F, 7.2F},
     {2.3F, 3.1F},
     {1.95F, 2.3F},
     {0.44F, 0.52F},
     {0.38F, 0.48F},
     {0.32F, 0.4F},
     {0.02F, 0.12F},
     {0.15F, 0.5F},
     {0.F, 0.01F},
     {0.6F, 0.7F},
     {0.F, 0.08F},
     {0.36F, 0.45F},
     {0.02F, 0.07F},
     {0.03F, 0.09F},
     0.1,
     3},
    // Buses.
    {0.04,
     {6.5F, 12.F},
     {2.6F, 3.3F},
     {2.1F, 2.55F},
     {0.38F, 0.48F},
     {0.3F, 0.38F},
     {0.26F, 0.3F},
     {0.004F, 0.03F},
     {0.05F, 0.35F},
     {0.F, 0.01F},
     {0.6F, 0.7F},
     {0.F, 0.12F},
     {0.42F, 0.5F},
     {0.02F, 0.06F},
     {0.03F, 0.08F},
     1.0,
     8},
    // Pick-ups.
    {0.04,
     {4.7F, 5.5F},
     {1.6F, 1.9F},
     {1.72F, 2.F},
     {0.56F, 0.62F},
     {0.58F, 0.64F},
     {0.5F, 0.58F},
     {0.2F, 0.26F},
     {0.5F, 0.8F},
     {0.26F, 0.38F},
     {0.5F, 0.62F},
     {0.06F, 0.3F},
     {0.34F, 0.4F},
     {0.14F, 0.24F},
     {0.06F, 0.14F},
     0.8,
     1},
}};

// Share of box trucks, whose cab is of none of the makes above.
constexpr double kBoxTrucks = 0.06;
constexpr Make kCab{0.0,
                    {1.6F, 2.3F},
                    {1.95F, 2.9F},
                    {1.85F, 2.4F},
                    {0.5F, 0.6F},
                    {0.44F, 0.56F},
                    {0.38F, 0.46F},
                    {0.02F, 0.2F},
                    {0.12F, 0.4F},
                    {0.F, 0.01F},
                    {0.6F, 0.7F},
                    {0.F, 0.1F},
                    {0.34F, 0.5F},
                    {0.05F, 0.14F},
                    {0.06F, 0.14F},
                    0.0,
                    1};

float draw(Random& random, const Range& range) {
  return static_cast<float>(random.uniform(range.low, range.high));
}

float draw(Random& random, float low, float high) {
  return draw(random, Range{low, high});
}

const Make& any_make(Random& random) {
  double left = random.unit();
  for (const Make& make : kMakes) {
    left -= make.share;
    if (left < 0.0) {
      return make;
    }
  }
  return kMakes.front();
}

// Most cars are black, white or silver.
float any_paint(Random& random) {
  const double kind = random.unit();
  if (kind < 0.35) {
    return draw(random, 0.012F, 0.07F);
  }
  return kind < 0.6 ? draw(random, 0.55F, 0.9F) : draw(random, 0.05F, 0.6F);
}

BodyTrim any_trim(Random& random, const BodyShape& shape, int pillars) {
  BodyTrim trim;
  trim.paint = any_paint(random);
  trim.paint_gloss = draw(random, 0.01F, 0.12F);
  trim.glass = random.chance(0.7) ? draw(random, 0.008F, 0.05F) : draw(random, 0.05F, 0.3F);
  trim.glass_gloss = draw(random, 0.03F, 0.14F);
  trim.pillars = std::max(1, pillars - random.index(2));
  trim.pillar_pitch_m = draw(random, 0.8F, 1.3F);
  trim.sill_m = shape.clearance_m + draw(random, 0.02F, 0.2F);
  trim.strip_m = draw(random, 0.4F, 0.7F);
  trim.plate_front_m = draw(random, 0.3F, 0.55F);
  trim.plate_rear_m = random.chance(0.5) ? draw(random, 0.35F, 0.6F) : draw(random, 0.6F, 0.9F);
  // Front details move with the bonnet's edge.
  const float nose = std::max(0.55F, shape.belt_m * draw(random, 0.62F, 0.78F));
  trim.headlamp_m = nose;
  trim.headlamp_radius_m = draw(random, 0.08F, 0.22F);
  trim.headlamp_squeeze = draw(random, 0.8F, 2.6F);
  trim.headlamp_out = draw(random, 0.62F, 0.84F);
  trim.grille_low_m = nose - draw(random, 0.04F, 0.2F);
  trim.grille_high_m = nose + draw(random, 0.02F, 0.15F);
  trim.grille_half = draw(random, 0.15F, 0.6F);
  const float lamp = shape.belt_m * draw(random, 0.55F, 0.95F);
  trim.rear_lamp_low_m = lamp;
  trim.rear_lamp_high_m = lamp + (random.chance(0.4) ? draw(random, 0.3F, 0.7F) : draw(random, 0.1F, 0.25F));
  trim.rear_lamp_out = draw(random, 0.45F, 0.85F);
  return trim;
}

struct Body {
  BodyShape shape;
  std::vector<OutlinePoint> outline;
};

Body any_body(Random& random, const Make& make) {
  Body body;
  BodyShape& s = body.shape;
  s.length_m = draw(random, make.length_m);
  s.height_m = draw(random, make.height_m);
  s.width_m = draw(random, make.width_m);
  s.belt_m = s.height_m * draw(random, make.belt);
  s.wheel_radius_m = draw(random, make.wheel_m);
  s.clearance_m = 0.45F * s.wheel_radius_m + draw(random, 0.F, 0.06F);
  s.lean = draw(random, make.lean);
  s.rounding = draw(random, make.rounding);
  const float half = 0.5F * s.length_m;
  const float overhang = std::min(s.wheel_radius_m + draw(random, 0.25F, 0.6F), 0.8F * half);
  s.front_axle_m = half - overhang;
  s.rear_axle_m = -half + std::min(s.wheel_radius_m + draw(random, 0.2F, 0.12F * s.length_m + 0.2F), 0.8F * half);
  s.windscreen_m = half - s.length_m * draw(random, make.bonnet);
  s.windscreen_top_m = s.windscreen_m - draw(random, make.windscreen_m);
  s.rear_window_m = -half + 0.02F + s.length_m * draw(random, make.boot);
  s.rear_window_top_m = std::min(s.rear_window_m + draw(random, make.rear_window_m), s.windscreen_top_m - 0.4F);
  s.has_rear_side_windows = random.chance(make.rear_side_windows);
  const float deck = draw(random, make.deck);
  const float bonnet_front = draw(random, make.bonnet_front);
  const float bonnet_rear = std::max(draw(random, make.bonnet_rear), bonnet_front + 0.02F);
  const float bow = draw(random, 0.96F, 0.995F);  // Height of the roof's ends.
  const auto at = [&](float x_m) { return x_m / s.length_m; };
  const float rear_foot = at(s.rear_window_m);
  const float front_foot = at(s.windscreen_m);
  const float nose = std::min(0.485F, 0.5F - 0.1F * (0.5F - front_foot));
  body.outline = {{-0.5F, draw(random, 0.28F, 0.4F)},
                  {-0.497F, 0.85F * deck},
                  {std::min(-0.49F, rear_foot - 0.002F), 0.97F * deck},
                  {rear_foot, deck},
                  {at(s.rear_window_top_m), bow},
                  {0.6F * at(s.rear_window_top_m) + 0.4F * at(s.windscreen_top_m), 1.F},
                  {at(s.windscreen_top_m), bow},
                  {front_foot, bonnet_rear},
                  {0.5F * (front_foot + nose), 0.45F * bonnet_rear + 0.55F * bonnet_front},
                  {nose, bonnet_front},
                  {0.5F * (nose + 0.5F), 0.85F * bonnet_front},
                  {0.5F, draw(random, 0.2F, 0.34F)}};
  s.trim = any_trim(random, s, make.pillars);
  if (!s.has_rear_side_windows) {
    s.trim.has_rear_window = random.chance(0.4);
    s.trim.print = random.chance(0.5) ? any_paint(random) : -1.F;
  }
  return body;
}

// Puts a box behind the cab.
void load_truck(Random& random, VehicleDesign& design) {
  constexpr std::array<Material, 4> kSheets{Material::kTruckBox, Material::kPlain, Material::kPoster, Material::kMetal};
  BodyShape& cab = design.shape;
  design.box_length_m = draw(random, 2.4F, 7.F);
  design.box_height_m = cab.height_m * draw(random, 0.95F, 1.45F);
  design.box_floor_m = draw(random, 0.55F, 1.F);
  design.box = kSheets[static_cast<std::size_t>(random.index(kSheets.size()))];
  design.box_tone = draw(random, 0.3F, 1.8F);
  cab.front_axle_m = draw(random, -0.1F, 0.3F) * cab.length_m;
  cab.rear_axle_m = -0.5F * cab.length_m - design.box_length_m * draw(random, 0.6F, 0.85F);
  cab.origin_x_m = 0.5F * design.box_length_m;
}

// Optional load on the roof.
float load_roof(Random& random, const VehicleDesign& design, Mesh& mesh) {
  const BodyShape& s = design.shape;
  const float low = std::max(s.height_m, design.box_height_m);
  const float tall = draw(random, 0.1F, 0.4F);
  const float middle = 0.5F * (s.windscreen_top_m + s.rear_window_top_m);
  const float reach = s.windscreen_top_m - s.rear_window_top_m;
  const Material material = random.chance(0.5) ? Material::kPlain : Material::kPoster;
  mesh.add_box({middle, -low - 0.5F * tall, 0.F},
               {reach * draw(random, 0.3F, 0.9F), tall, s.width_m * draw(random, 0.3F, 0.6F)},
               {material, static_cast<std::uint16_t>(random.bits()), nullptr, draw(random, 0.1F, 1.8F)});
  return tall;
}

// Opens the driver's or the passenger's door; returns where a person stands to get in.
Eigen::Vector2f open_door(Random& random, const VehicleDesign& design, std::uint16_t seed, Mesh& mesh) {
  constexpr float kThick_m = 0.07F;
  const BodyShape& s = design.shape;
  const float side = random.chance(0.5) ? 1.F : -1.F;
  const float wide = draw(random, 0.85F, 1.2F);
  const float angle = draw(random, 0.4F, 1.25F);
  const float low = s.clearance_m + 0.1F;
  const float tall = std::min(s.height_m - 0.1F, 2.1F) - low;
  const float hinge_x = s.origin_x_m + s.windscreen_m - 0.12F;
  const float hinge_z = 0.5F * s.width_m;
  // The interior visible through the opening.
  mesh.add_box({hinge_x - 0.5F * wide, -low - 0.5F * tall, side * (hinge_z - 0.02F)}, {0.95F * wide, tall, 0.06F},
               {Material::kPlain, seed, nullptr, draw(random, 0.03F, 0.4F)});
  const Vector3f middle(hinge_x - 0.5F * wide * std::cos(angle), -low - 0.5F * tall,
                        side * (hinge_z + 0.5F * wide * std::sin(angle)));
  mesh.add_box(middle, {wide, tall, kThick_m}, {Material::kCarBody, seed, &s}, turned(side * angle));
  return {hinge_x - draw(random, 0.4F, 1.1F), side * (hinge_z + draw(random, 0.75F, 0.95F))};
}

}  // namespace

RandomVehicle random_vehicle(Random& random) {
  const bool is_truck = random.chance(kBoxTrucks);
  const Body body = any_body(random, is_truck ? kCab : any_make(random));
  const auto design = std::make_shared<VehicleDesign>();
  design->shape = body.shape;
  design->outline = body.outline;
  if (is_truck) {
    load_truck(random, *design);
  }
  const auto seed = static_cast<std::uint16_t>(random.bits());
  const auto rim_seed = static_cast<std::uint16_t>(random.bits());
  RandomVehicle vehicle{
      {design, &design->shape}, vehicle_mesh(*design, seed, rim_seed), vehicle_size_m(*design), std::nullopt};
  if (random.chance(0.15)) {
    vehicle.doorway_m = open_door(random, *design, seed, vehicle.mesh);
  }
  if (!is_truck && random.chance(0.06)) {
    vehicle.size_lhw_m.y() += load_roof(random, *design, vehicle.mesh);
  }
  return vehicle;
}

}  // namespace kinetrace::simulator
