// A drive through traffic.
#include "scenes/scenes.hpp"
#include "scenes/street_kit.hpp"
#include "world/people.hpp"

namespace kinetrace::simulator {
namespace {

using Points = std::vector<Eigen::Vector2d>;

// Lane centres: we drive on the right.
constexpr double kOuter_m = 5.2;
constexpr double kInner_m = 1.8;

GroundPath along_z(double x, double z0, double z1) {
  return GroundPath(Points{{x, z0}, {x, z1}});
}

void add_moving_vehicles(Scene& scene, const Variation& variation) {
  const auto add = [&](VehicleKind kind, std::uint16_t seed, Points points, SpeedProfile speed, double start_m) {
    scene.actors.push_back(
        driven_vehicle(variation, kind, seed, GroundPath(std::move(points)), std::move(speed), start_m));
  };
  // The car ahead: in view all the time.
  add(VehicleKind::kHatchback, 3, {{kOuter_m, 0}, {kOuter_m, 40}, {kOuter_m - 0.2, 80}, {kOuter_m, 160}},
      SpeedProfile({{0.0, 7.5}, {3.0, 9.0}, {6.0, 6.5}, {9.0, 8.5}}), 13.0);
  // Overtakes on the inner lane.
  add(VehicleKind::kSedan, 4,
      {{kInner_m, -20},
       {kInner_m, 0},
       {kInner_m, 25},
       {kInner_m, 45},
       {kInner_m, 62},
       {kInner_m, 110},
       {kInner_m, 160}},
      SpeedProfile({{0.0, 11.0}, {5.0, 11.5}, {9.0, 9.0}}), 13.0);
  // Oncoming, one after the other.
  add(VehicleKind::kTruck, 5, {{-kInner_m, 150}, {-kInner_m, -60}}, SpeedProfile({{0.0, 8.0}, {8.0, 7.0}}), 112.0);
  add(VehicleKind::kHatchback, 6, {{-kInner_m, 150}, {-kInner_m, -60}}, SpeedProfile({{0.0, 9.0}, {5.0, 8.0}}), 86.0);
  add(VehicleKind::kVan, 7, {{-kOuter_m, 150}, {-kOuter_m, -60}}, SpeedProfile({{0.0, 7.5}}), 86.0);
  // Out of the side street on the right, then far ahead of the camera.
  add(VehicleKind::kSedan, 8,
      {{60, 63.5}, {30, 63.5}, {17, 63.5}, {11, 63.8}, {6.8, 66.5}, {5.4, 72}, {5.2, 80}, {5.2, 100}, {5.2, 160}},
      SpeedProfile({{0.0, 6.0}, {2.0, 4.5}, {4.5, 4.5}, {7.5, 8.5}}), 36.0);
  // Comes towards us and turns across our lanes into the side street.
  add(VehicleKind::kHatchback, 9,
      {{-1.8, 150}, {-1.8, 100}, {-1.8, 78}, {-1.5, 70}, {1, 63.5}, {6, 60}, {13, 59.4}, {30, 59.4}, {70, 59.4}},
      SpeedProfile({{0.0, 8.0}, {3.0, 5.5}, {6.0, 7.0}}), 64.0);
}

void add_people(Scene& scene, const Variation& variation) {
  scene.actors.push_back(passer_by(variation, along_z(10.6, 60, 0), SpeedProfile({{0.0, 1.35}}), 26.0, 1));
  scene.actors.push_back(passer_by(variation, along_z(-10.6, 0, 90), SpeedProfile({{0.0, 1.5}}), 22.0, 2));
  // Has just stepped off the curb.
  scene.actors.push_back(walking_person(GroundPath(Points{{8.6, 69.0}, {0, 69.0}, {-9.6, 69.0}, {-20, 69.0}}),
                                        variation.paced(SpeedProfile({{0.0, 1.4}}), 3), 0.0, variation.look(3),
                                        variation.height_m(3)));
}

void add_parked_vehicles(Scene& scene, const Variation& variation) {
  constexpr std::array<ParkingSpot, 12> kSpots{{{VehicleKind::kHatchback, 1, 12},
                                                {VehicleKind::kSedan, 1, 24.5},
                                                {VehicleKind::kVan, 1, 31.5},
                                                {VehicleKind::kHatchback, 1, 46},
                                                {VehicleKind::kSedan, 1, 84},
                                                {VehicleKind::kHatchback, 1, 97},
                                                {VehicleKind::kSedan, -1, 15},
                                                {VehicleKind::kHatchback, -1, 21},
                                                {VehicleKind::kHatchback, -1, 37},
                                                {VehicleKind::kVan, -1, 49},
                                                {VehicleKind::kSedan, -1, 81},
                                                {VehicleKind::kTruck, -1, 93}}};
  std::uint16_t seed = 20;
  for (ParkingSpot spot : kSpots) {
    spot.askew_rad = 0.02 * (seed % 3 - 1);
    add_parked(scene, variation, spot, seed);
    ++seed;
  }
}

}  // namespace

Scene street_scene(const Variation& variation) {
  Scene scene;
  StreetPlan plan;
  plan.seed = variation.seed(plan.seed);
  scene.world = street_world(plan);
  scene.rig = car_rig();
  add_moving_vehicles(scene, variation);
  add_people(scene, variation);
  add_parked_vehicles(scene, variation);
  const Sway sway{{0.004, 0.004, 0.003}, {0.01, 0.012, 0.0}, 0.4, 2.5, variation.seed(5)};
  scene.T_scene_cam = mounted(drive(GroundPath(Points{{kOuter_m, -30},
                                                      {kOuter_m, 0},
                                                      {kOuter_m - 0.3, 25},
                                                      {kOuter_m + 0.2, 50},
                                                      {kOuter_m, 75},
                                                      {kOuter_m, 130}}),
                                    SpeedProfile({{0.0, 7.0}, {4.0, 8.5}, {7.0, 6.5}, {10.0, 8.0}}), 30.0),
                              1.65, 0.0, sway);
  return scene;
}

}  // namespace kinetrace::simulator
