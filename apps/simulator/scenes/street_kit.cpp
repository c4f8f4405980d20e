#include "scenes/street_kit.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "util/random.hpp"
#include "world/people.hpp"
#include "world/scenery.hpp"

namespace kinetrace::simulator {
namespace {

float uniform(Random& random, double low, double high) {
  return static_cast<float>(random.uniform(low, high));
}

struct Stretch {
  float z0;
  float z1;
};

void add_roadway(Mesh& mesh, const StreetPlan& plan) {
  const float road = plan.half_road_m + plan.parking_m;
  add_ground(mesh, {-150.F, 150.F, plan.z0_m - 60.F, plan.z1_m + 80.F}, -0.02F, {Material::kGrass});
  add_ground(mesh, {-road, road, plan.z0_m - 60.F, plan.z1_m + 80.F}, 0.F, {Material::kAsphalt});
  const float crossing0 = plan.crossing_z_m - plan.half_crossing_m;
  const float crossing1 = plan.crossing_z_m + plan.half_crossing_m;
  add_ground(mesh, {-100.F, -road, crossing0, crossing1}, 0.F, {Material::kAsphalt});
  add_ground(mesh, {road, 100.F, crossing0, crossing1}, 0.F, {Material::kAsphalt});
  add_road_wear(mesh, {-plan.half_road_m, plan.half_road_m, plan.z0_m, plan.z1_m}, 60, plan.seed);
  const float half_lane = 0.5F * plan.half_road_m;
  for (const auto& [z0, z1] :
       {Stretch{plan.z0_m - 60.F, crossing0 - 5.F}, Stretch{crossing1 + 5.F, plan.z1_m + 80.F}}) {
    add_lane_marks(mesh, -half_lane, z0, z1, 3.F, 4.5F);
    add_lane_marks(mesh, half_lane, z0 + 2.F, z1, 3.F, 4.5F);
    add_lane_marks(mesh, -0.12F, z0, z1, 40.F, 0.F);
    add_lane_marks(mesh, 0.12F, z0, z1, 40.F, 0.F);
    add_lane_marks(mesh, -plan.half_road_m, z0, z1, 5.F, 0.2F);
    add_lane_marks(mesh, plan.half_road_m, z0, z1, 5.F, 0.2F);
  }
  add_crosswalk(mesh, -plan.half_road_m, plan.half_road_m, crossing0 - 2.4F);
  add_crosswalk(mesh, -plan.half_road_m, plan.half_road_m, crossing1 + 2.4F);
}

// Everything along one side of a stretch of road; `side` is -1 left, 1 right.
void add_roadside(Mesh& mesh, const StreetPlan& plan, const Stretch& stretch, float side, std::uint32_t seed) {
  const float road = plan.half_road_m + plan.parking_m;
  const float house = road + plan.sidewalk_m;
  const auto area = [&](float from, float to, float z0, float z1) {
    return side > 0.F ? GroundArea{from, to, z0, z1} : GroundArea{-to, -from, z0, z1};
  };
  add_slab(mesh, area(road, house, stretch.z0, stretch.z1), kCurb_m, {Material::kSidewalk}, {Material::kCurb});
  add_slab(mesh, area(road - 0.15F, road, stretch.z0, stretch.z1), kCurb_m - 0.005F, {Material::kCurb},
           {Material::kCurb});
  Random random(seed, side > 0.F ? 1 : 2, stretch.z0);
  float z = stretch.z0;
  while (z < stretch.z1 - 5.F) {
    const float length = std::min(uniform(random, 9.0, 18.0), stretch.z1 - z);
    const auto variant = static_cast<std::uint16_t>(random.bits());
    if (random.chance(0.78)) {
      const float back = uniform(random, 0.2, 3.5);
      const float deep = uniform(random, 8.0, 11.0);
      add_building(mesh, area(house + back, house + back + deep, z, z + length),
                   3.F * static_cast<float>(2 + random.index(3)) + 0.6F, random.chance(0.6), variant);
      if (back > 1.6F) {
        add_hedge(mesh, area(house + 0.1F, house + 1.F, z + 1.F, z + length - 1.F), 1.2F, variant);
      }
    } else {
      add_fence(mesh, side * (house + 0.2F), z, z + length, variant);
      add_tree(mesh, side * (house + uniform(random, 3.0, 5.0)), z + 0.5F * length, uniform(random, 6.0, 9.0), variant);
      add_hedge(mesh, area(house + 7.F, house + 9.F, z, z + length), 2.8F, variant);
    }
    z += length + (random.chance(0.5) ? 0.F : uniform(random, 1.5, 4.0));
  }
  for (float at = stretch.z0 + 6.F; at < stretch.z1; at += 24.F) {
    const auto variant = static_cast<std::uint16_t>(random.bits());
    add_lamp(mesh, side * (road + 0.5F), at, -side * 1.8F, variant);
    // The last tree's crown must not hang over the cross street.
    constexpr float kCrown_m = 3.F;
    const float tree_z = std::min(at + 9.F, stretch.z1 - kCrown_m);
    add_tree(mesh, side * (road + 0.8F), tree_z, uniform(random, 4.5, 6.5), variant);
    if (const float sign_z = at + 15.F; sign_z < stretch.z1) {
      add_sign(mesh, side * (road + 0.5F), sign_z, variant);
    }
  }
}

void add_backdrop(Mesh& mesh, const StreetPlan& plan) {
  Random random(plan.seed, 99);
  for (int i = 0; i < 14; ++i) {
    const float x = -90.F + 13.F * static_cast<float>(i);
    add_building(mesh, {x, x + uniform(random, 9.0, 13.0), plan.z1_m + 85.F, plan.z1_m + 97.F},
                 uniform(random, 9.0, 24.0), random.chance(0.3), static_cast<std::uint16_t>(random.bits()));
  }
  for (const float side : {-1.F, 1.F}) {
    for (int i = 0; i < 6; ++i) {
      add_tree(mesh, side * (30.F + 9.F * static_cast<float>(i)), plan.crossing_z_m + plan.half_crossing_m + 3.F,
               uniform(random, 5.0, 8.0), static_cast<std::uint16_t>(random.bits()));
    }
  }
}

}  // namespace

Mesh street_world(const StreetPlan& plan) {
  Mesh mesh;
  add_roadway(mesh, plan);
  const float gap = plan.half_crossing_m + 0.5F;
  for (const float side : {-1.F, 1.F}) {
    add_roadside(mesh, plan, {plan.z0_m, plan.crossing_z_m - gap}, side, plan.seed);
    add_roadside(mesh, plan, {plan.crossing_z_m + gap, plan.z1_m}, side, plan.seed);
  }
  add_backdrop(mesh, plan);
  return mesh;
}

StereoGeometry car_rig() {
  return {721.5, 721.5, 609.6, 172.9, 0.54, 1242, 375};
}

Actor vehicle(VehicleKind kind, std::uint16_t seed, Trajectory trajectory) {
  Actor actor;
  actor.class_id = kVehicleClass;
  actor.size_lhw_m = vehicle_size_m(kind).cast<double>();
  actor.parts.push_back(vehicle_mesh(kind, seed));
  actor.T_scene_obj = std::move(trajectory);
  return actor;
}

Actor driven_vehicle(const Variation& variation, VehicleKind kind, std::uint16_t seed, GroundPath path,
                     SpeedProfile speed, double start_m) {
  constexpr double kMaxAside_m = 0.2;
  Trajectory way = drive(std::move(path), variation.paced(std::move(speed), seed), start_m);
  return vehicle(kind, variation.look(seed), variation.aside(std::move(way), kMaxAside_m, seed));
}

void add_parked(Scene& scene, const Variation& variation, const ParkingSpot& spot, std::uint16_t seed) {
  if (variation.is_empty(seed)) {
    return;
  }
  constexpr double kUsual_m = 7.95;
  constexpr double kCurbstone_m = 8.93;
  const VehicleKind kind = variation.kind(spot.kind, seed);
  const Eigen::Vector3d half_m = 0.5 * vehicle_size_m(kind).cast<double>();
  const double reach_m = half_m.z() * std::cos(spot.askew_rad) + half_m.x() * std::abs(std::sin(spot.askew_rad));
  // Broad vehicles keep off the curb.
  const double x_m = spot.side * std::min(kUsual_m, kCurbstone_m - reach_m);
  const double heading_rad = (spot.side > 0.0 ? kAlongZ_rad : kAgainstZ_rad) + spot.askew_rad;
  scene.actors.push_back(
      vehicle(kind, variation.look(seed), parked(x_m, variation.place_m(spot.z_m, seed), heading_rad)));
}

Actor passer_by(const Variation& variation, GroundPath path, SpeedProfile speed, double start_m, std::uint16_t seed) {
  constexpr double kMaxAside_m = 0.12;
  Actor actor = walking_person(std::move(path), variation.paced(std::move(speed), seed), start_m, variation.look(seed),
                               variation.height_m(seed));
  actor.T_scene_obj =
      variation.aside(raised(std::move(actor.T_scene_obj), static_cast<double>(kCurb_m)), kMaxAside_m, seed);
  return actor;
}

}  // namespace kinetrace::simulator
