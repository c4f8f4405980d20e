// From a small aircraft: looking down and ahead, shaken in all six degrees of freedom.
#include "scenes/scenes.hpp"
#include "scenes/street_kit.hpp"
#include "world/people.hpp"

namespace kinetrace::simulator {
namespace {

using Points = std::vector<Eigen::Vector2d>;

constexpr double kCrossing_m = 34.0;

void add_vehicles(Scene& scene, const Variation& variation) {
  const auto add = [&](VehicleKind kind, std::uint16_t seed, Points points, SpeedProfile speed, double start_m) {
    scene.actors.push_back(
        driven_vehicle(variation, kind, seed, GroundPath(std::move(points)), std::move(speed), start_m));
  };
  // Along with us, slower and faster.
  add(VehicleKind::kSedan, 41, {{1.8, -40}, {1.8, 160}}, SpeedProfile({{0, 5.0}, {4, 6.5}, {8, 4.5}}), 47.0);
  add(VehicleKind::kVan, 42, {{5.2, -40}, {5.2, 160}}, SpeedProfile({{0, 4.0}, {5, 5.5}}), 56.0);
  // Oncoming.
  add(VehicleKind::kHatchback, 43, {{-1.8, 150}, {-1.8, -60}}, SpeedProfile({{0, 6.0}, {6, 5.0}}), 117.0);
  add(VehicleKind::kTruck, 44, {{-5.2, 150}, {-5.2, -60}}, SpeedProfile({{0, 5.5}}), 100.0);
  // Crossing from both sides, the second one turns our way.
  add(VehicleKind::kHatchback, 45, {{-60, kCrossing_m - 2.2}, {60, kCrossing_m - 2.2}},
      SpeedProfile({{0, 6.5}, {5, 6.0}}), 20.0);
  add(VehicleKind::kSedan, 46,
      {{60, kCrossing_m + 2.2},
       {20, kCrossing_m + 2.2},
       {11, kCrossing_m + 2.2},
       {7, kCrossing_m + 4},
       {5.4, kCrossing_m + 9},
       {5.2, kCrossing_m + 16},
       {5.2, 160}},
      SpeedProfile({{0, 5.0}, {5, 4.0}, {9, 6.5}}), 22.0);
}

void add_parked_vehicles(Scene& scene, const Variation& variation) {
  constexpr std::array<ParkingSpot, 7> kSpots{{{VehicleKind::kHatchback, 1, 8},
                                               {VehicleKind::kSedan, 1, 14.5},
                                               {VehicleKind::kVan, -1, 12},
                                               {VehicleKind::kHatchback, -1, 22},
                                               {VehicleKind::kSedan, 1, 52},
                                               {VehicleKind::kHatchback, -1, 55},
                                               {VehicleKind::kSedan, -1, 63}}};
  std::uint16_t seed = 60;
  for (const ParkingSpot& spot : kSpots) {
    add_parked(scene, variation, spot, seed);
    ++seed;
  }
}

}  // namespace

Scene drone_scene(const Variation& variation) {
  Scene scene;
  StreetPlan plan;
  plan.crossing_z_m = static_cast<float>(kCrossing_m);
  plan.seed = variation.seed(7);
  scene.world = street_world(plan);
  scene.light.exposure = 1.15F;
  scene.rig = {458.0, 458.0, 375.5, 239.5, 0.20, 752, 480};
  scene.rate_hz = 20.0;
  scene.frames = 200;
  add_vehicles(scene, variation);
  add_parked_vehicles(scene, variation);
  scene.actors.push_back(
      passer_by(variation, GroundPath(Points{{10.6, 70}, {10.6, 0}}), SpeedProfile({{0, 1.4}}), 44.0, 5));
  scene.actors.push_back(
      passer_by(variation, GroundPath(Points{{-10.6, 0}, {-10.6, 90}}), SpeedProfile({{0, 1.5}}), 12.5, 6));
  const Sway sway{{0.03, 0.025, 0.035}, {0.12, 0.1, 0.12}, 0.25, 3.0, variation.seed(9)};
  scene.T_scene_cam =
      mounted(drive(GroundPath(Points{{3, -20}, {2.5, 0}, {0.5, 15}, {1.5, 30}, {-1, 45}, {0, 60}, {0, 100}}),
                    SpeedProfile({{0, 3.0}, {3, 5.0}, {7, 3.5}, {10, 4.5}}), 13.0),
              13.0, 0.75, sway);
  return scene;
}

}  // namespace kinetrace::simulator
