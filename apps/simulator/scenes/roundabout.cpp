// A roundabout between two streets: vehicles that look the same pass behind buses, trees, bushes and each other.
#include <array>
#include <cmath>
#include <numbers>
#include <utility>
#include <vector>

#include "scenes/scenes.hpp"
#include "scenes/street_kit.hpp"
#include "util/random.hpp"
#include "world/scenery.hpp"

namespace kinetrace::simulator {
namespace {

using Points = std::vector<Eigen::Vector2d>;

// Traffic keeps to the right, so anticlockwise around the island.
constexpr double kCentre_m = 10.0;  // z of the island's middle.
constexpr double kInner_m = 10.0;
constexpr double kOuter_m = 14.5;
// z of the lanes of both streets; the near ones of each go to the right.
constexpr std::array<double, 2> kFrontStreet_m{-15.2, -11.6};
constexpr std::array<double, 2> kRearStreet_m{33.0, 36.6};
// So far out that no vehicle reaches the end.
constexpr double kFarOut_m = 320.0;

/// Vehicles at the same speed, one behind the other.
struct Stream {
  struct Member {
    VehicleKind kind = VehicleKind::kHatchback;
    double start_m = 0.0;
  };
  std::uint16_t key = 0;  ///< Of its variation.
  GroundPath path;
  SpeedProfile speed;
  std::vector<Member> members;
};

void add_stream(Scene& scene, const Variation& variation, const Stream& stream) {
  constexpr double kMaxAside_m = 0.2;
  std::uint32_t key = 32U * stream.key;
  for (const Stream::Member& member : stream.members) {
    Trajectory way = drive(stream.path, variation.paced(stream.speed, stream.key), member.start_m);
    // The same look for all of a kind.
    const std::uint16_t look = variation.look(static_cast<std::uint16_t>(100 + static_cast<int>(member.kind)));
    scene.actors.push_back(vehicle(member.kind, look, variation.aside(std::move(way), kMaxAside_m, ++key)));
  }
}

// From the angle `from_rad` on, counted from the point nearest to us.
void add_arc(Points& points, double radius_m, double from_rad, double to_rad) {
  constexpr double kStep_rad = std::numbers::pi / 9.0;
  for (double angle = from_rad; angle < to_rad + 0.5 * kStep_rad; angle += kStep_rad) {
    points.emplace_back(radius_m * std::sin(angle), kCentre_m - radius_m * std::cos(angle));
  }
}

GroundPath rounds(double radius_m, int count) {
  Points points;
  add_arc(points, radius_m, 0.0, 2.0 * std::numbers::pi * count);
  return GroundPath(std::move(points));
}

// In from the left on the near side, half around, and out on the far side.
GroundPath turning_back() {
  Points points{{-kFarOut_m, kCentre_m - kOuter_m}, {-30.0, kCentre_m - kOuter_m}, {-8.0, kCentre_m - kOuter_m}};
  add_arc(points, kOuter_m, 0.0, std::numbers::pi);
  points.emplace_back(-8.0, kCentre_m + kOuter_m);
  points.emplace_back(-30.0, kCentre_m + kOuter_m);
  points.emplace_back(-kFarOut_m, kCentre_m + kOuter_m);
  return GroundPath(std::move(points));
}

GroundPath along_x(double z, double direction) {
  return GroundPath(Points{{-direction * kFarOut_m, z}, {direction * kFarOut_m, z}});
}

// Position on such a path, `before_m` short of x = 0.
constexpr double short_of(double before_m) {
  return kFarOut_m - before_m;
}

void add_traffic(Scene& scene, const Variation& variation) {
  constexpr VehicleKind kCar = VehicleKind::kHatchback;
  constexpr VehicleKind kSedan = VehicleKind::kSedan;
  constexpr VehicleKind kBus = VehicleKind::kBus;
  // Passes close to the camera.
  add_stream(scene, variation,
             {1,
              along_x(kFrontStreet_m[0], 1.0),
              SpeedProfile({{0, 7.0}, {8, 9.0}, {16, 5.5}, {24, 8.0}}),
              {{kSedan, short_of(24)},
               {kSedan, short_of(58)},
               {kSedan, short_of(95)},
               {kSedan, short_of(163)},
               {kSedan, short_of(177)}}});
  add_stream(scene, variation,
             {2,
              along_x(kFrontStreet_m[1], -1.0),
              SpeedProfile({{0, 6.0}, {10, 7.5}, {20, 6.0}}),
              {{kSedan, short_of(10)},
               {kBus, short_of(42)},
               {kSedan, short_of(80)},
               {kSedan, short_of(104)},
               {kBus, short_of(150)}}});
  // Around the island; both lanes come nearly to a halt in the middle.
  Stream inner{3, rounds(kInner_m, 4), SpeedProfile({{0, 5.0}, {10, 5.5}, {14, 1.5}, {17, 1.5}, {21, 5.5}}), {}};
  for (const double start_m : {2.0, 20.0, 44.0}) {
    inner.members.push_back({kCar, start_m});
  }
  add_stream(scene, variation, inner);
  Stream outer{4, turning_back(), SpeedProfile({{0, 6.2}, {9, 6.0}, {13, 2.0}, {17, 2.0}, {22, 6.2}}), {}};
  for (const double before_m : {-48.0, -30.0, -21.0, -6.0, 9.0, 20.0, 44.0, 66.0, 75.0, 102.0}) {
    outer.members.push_back({kCar, short_of(before_m)});
  }
  add_stream(scene, variation, outer);
  // Visible through gaps in the traffic in front of it.
  add_stream(scene, variation,
             {5,
              along_x(kRearStreet_m[0], 1.0),
              SpeedProfile({{0, 8.0}, {15, 6.0}, {25, 8.0}}),
              {{kCar, short_of(-20)},
               {kCar, short_of(-6)},
               {kBus, short_of(15)},
               {kCar, short_of(47)},
               {kCar, short_of(100)},
               {kCar, short_of(112)},
               {kCar, short_of(165)}}});
  add_stream(scene, variation,
             {6,
              along_x(kRearStreet_m[1], -1.0),
              SpeedProfile({{0, 7.0}, {12, 9.0}, {22, 7.0}}),
              {{kCar, short_of(-14)},
               {kCar, short_of(12)},
               {kCar, short_of(24)},
               {kCar, short_of(68)},
               {kBus, short_of(101)},
               {kCar, short_of(140)},
               {kCar, short_of(186)}}});
}

void add_roads(Mesh& mesh, std::uint32_t seed) {
  constexpr float kEnd_m = kFarOut_m + 80.F;
  constexpr float kHalfStreet_m = 3.7F;
  add_ground(mesh, {-kEnd_m, kEnd_m, -120.F, 160.F}, -0.02F, {Material::kGrass});
  const auto street = [&](const std::array<double, 2>& lanes_m) {
    const float middle = static_cast<float>(0.5 * (lanes_m[0] + lanes_m[1]));
    add_ground(mesh, {-kEnd_m, kEnd_m, middle - kHalfStreet_m, middle + kHalfStreet_m}, 0.F, {Material::kAsphalt});
    for (float x = -90.F; x < 90.F; x += 7.5F) {
      add_ground(mesh, {x, x + 3.F, middle - 0.07F, middle + 0.07F}, 0.004F, {Material::kRoadMark});
    }
    add_road_wear(mesh, {-50.F, 50.F, middle - kHalfStreet_m + 1.F, middle + kHalfStreet_m - 1.F}, 12, seed);
  };
  street(kFrontStreet_m);
  street(kRearStreet_m);
  constexpr float kCentre = static_cast<float>(kCentre_m);
  constexpr float kOuter = static_cast<float>(kOuter_m) + 2.F;
  constexpr float kArm_m = 4.2F;
  constexpr float kAcross_m = 18.F;
  add_ground(mesh, {-kAcross_m, kAcross_m, kCentre - kOuter, kCentre + kOuter}, 0.F, {Material::kAsphalt});
  add_ground(mesh, {-kEnd_m, -kAcross_m, kCentre - kOuter, kCentre - kOuter + kArm_m}, 0.F, {Material::kAsphalt});
  add_ground(mesh, {-kEnd_m, -kAcross_m, kCentre + kOuter - kArm_m, kCentre + kOuter}, 0.F, {Material::kAsphalt});
  add_road_wear(mesh, {-16.F, 16.F, kCentre - kOuter, kCentre + kOuter}, 30, seed + 1);
}

void add_island(Mesh& mesh, Random& random) {
  constexpr float kCentre = static_cast<float>(kCentre_m);
  mesh.add_cylinder({0.F, 0.F, kCentre}, {0.F, -kCurb_m, kCentre}, 7.9F, 7.9F, 48, {Material::kCurb});
  mesh.add_cylinder({0.F, -kCurb_m, kCentre}, {0.F, -kCurb_m - 0.02F, kCentre}, 7.6F, 7.6F, 48, {Material::kGrass});
  for (const auto& [x, z] : {std::pair{-3.2F, -1.F}, {0.6F, 2.4F}, {3.4F, -2.F}}) {
    const auto height_m = static_cast<float>(random.uniform(5.0, 7.0));
    add_tree(mesh, x, kCentre + z, height_m, static_cast<std::uint16_t>(random.bits()));
  }
  add_hedge(mesh, {-5.F, -1.5F, kCentre - 3.F, kCentre - 2.F}, 1.5F, static_cast<std::uint16_t>(random.bits()));
  add_hedge(mesh, {1.F, 5.5F, kCentre + 2.F, kCentre + 3.F}, 1.7F, static_cast<std::uint16_t>(random.bits()));
}

// A strip of trees and bushes along a street, about `z`.
void add_green_strip(Mesh& mesh, Random& random, float z) {
  add_slab(mesh, {-90.F, 90.F, z - 1.3F, z + 1.3F}, kCurb_m, {Material::kGrass}, {Material::kCurb});
  constexpr float kPitch_m = 9.F;
  for (float x = -58.F; x < 60.F; x += kPitch_m) {
    const float at = x + static_cast<float>(random.uniform(-2.0, 2.0));
    const auto height_m = static_cast<float>(random.uniform(4.2, 5.0));
    add_tree(mesh, at, z, height_m, static_cast<std::uint16_t>(random.bits()));
    if (random.chance(0.5)) {
      add_hedge(mesh, {at + 1.5F, at + 5.F, z - 0.2F, z + 0.2F}, 1.3F, static_cast<std::uint16_t>(random.bits()));
    }
    if (random.chance(0.3)) {
      add_sign(mesh, at - 2.F, z, static_cast<std::uint16_t>(random.bits()));
    }
  }
}

void add_houses(Mesh& mesh, Random& random) {
  for (float x = -95.F; x < 95.F; x += 14.F) {
    const auto wide = static_cast<float>(random.uniform(9.0, 13.5));
    add_building(mesh, {x, x + wide, 44.F, 54.F}, static_cast<float>(random.uniform(6.0, 13.0)), random.chance(0.6),
                 static_cast<std::uint16_t>(random.bits()));
  }
  for (const auto& [x0, z0] : {std::pair{-62.F, 2.F}, {-44.F, 3.F}, {27.F, 2.F}, {46.F, 4.F}}) {
    add_building(mesh, {x0, x0 + 12.F, z0, z0 + 12.F}, static_cast<float>(random.uniform(5.0, 9.0)), random.chance(0.6),
                 static_cast<std::uint16_t>(random.bits()));
  }
}

}  // namespace

Scene roundabout_scene(const Variation& variation) {
  Scene scene;
  const std::uint32_t seed = variation.seed(51);
  Random random(seed, 1);
  add_roads(scene.world, seed);
  add_island(scene.world, random);
  add_green_strip(scene.world, random, -7.9F);
  add_green_strip(scene.world, random, 28.4F);
  add_houses(scene.world, random);
  scene.rig = car_rig();
  scene.frames = 300;
  add_traffic(scene, variation);
  // Creeps up to the street and looks around.
  const Sway sway{{0.004, 0.02, 0.003}, {0.01, 0.012, 0.0}, 0.1, 1.0, variation.seed(53)};
  scene.T_scene_cam = mounted(drive(GroundPath(Points{{-1.5, -60}, {-1.2, -33}, {-0.5, -27}, {0, -21}, {0, 0}}),
                                    SpeedProfile({{0.0, 0.2}, {10.0, 0.45}, {20.0, 0.25}}), 28.5),
                              1.65, 0.0, sway);
  return scene;
}

}  // namespace kinetrace::simulator
