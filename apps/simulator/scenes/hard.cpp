// Difficult scenes, for the robustness of estimators.
#include <cmath>

#include "scenes/scenes.hpp"
#include "scenes/street_kit.hpp"
#include "world/people.hpp"
#include "world/scenery.hpp"

namespace kinetrace::simulator {
namespace {

using Points = std::vector<Eigen::Vector2d>;

constexpr double kLane_m = 5.2;

Scene quiet_street(std::uint32_t seed) {
  Scene scene;
  StreetPlan plan;
  plan.seed = seed;
  scene.world = street_world(plan);
  scene.rig = car_rig();
  return scene;
}

void add_parked_vehicles(Scene& scene, const Variation& variation) {
  std::uint16_t seed = 90;
  for (const double z : {12.0, 19.0, 33.0, 47.0}) {
    for (const double side : {-1.0, 1.0}) {
      const VehicleKind kind = seed % 3 == 0 ? VehicleKind::kVan : VehicleKind::kHatchback;
      add_parked(scene, variation, {kind, side, z + side}, seed);
      ++seed;
    }
  }
}

Trajectory drive_along(double speed_mps, std::uint32_t seed) {
  const Sway sway{{0.004, 0.004, 0.003}, {0.01, 0.012, 0.0}, 0.4, 2.5, seed};
  return mounted(
      drive(GroundPath(Points{{kLane_m, -30}, {kLane_m, 40}, {kLane_m, 130}}), SpeedProfile({{0.0, speed_mps}}), 30.0),
      1.65, 0.0, sway);
}

Trajectory stand_at(double x_m, double z_m) {
  return mounted(parked(x_m, z_m, kAlongZ_rad), 1.65, 0.0, {});
}

}  // namespace

// At night: a hundredth of the light, an exposure that cannot compensate for it, hence mostly noise. Nothing moves.
Scene dark_scene(const Variation& variation) {
  Scene scene = quiet_street(variation.seed(31));
  add_parked_vehicles(scene, variation);
  scene.light.sun = 0.F;
  scene.light.ambient = 0.02F;
  scene.light.sky = 0.004F;
  scene.light.exposure = 1.4F;
  scene.T_scene_cam = drive_along(6.0, variation.seed(32));
  return scene;
}

// Bare walls and ground; a car of bare paint drives ahead.
Scene textureless_scene(const Variation& variation) {
  Scene scene;
  add_ground(scene.world, {-80.F, 80.F, -40.F, 200.F}, 0.F, {Material::kPlain, 3});
  for (const float side : {-1.F, 1.F}) {
    for (int i = 0; i < 5; ++i) {
      scene.world.add_box({side * 15.F, -4.F, 14.F + 24.F * static_cast<float>(i)}, {10.F, 8.F, 18.F},
                          {Material::kPlain, variation.look(static_cast<std::uint16_t>(4 + i))});
    }
  }
  scene.world.add_box({0.F, -5.F, 150.F}, {60.F, 10.F, 4.F}, {Material::kPlain, 12});
  scene.rig = car_rig();
  scene.actors.push_back(driven_vehicle(variation, VehicleKind::kHatchback, 83,
                                        GroundPath(Points{{kLane_m, 0}, {kLane_m, 200}}), SpeedProfile({{0.0, 7.0}}),
                                        14.0));
  scene.T_scene_cam = drive_along(6.0, variation.seed(34));
  return scene;
}

// The rig rotates and tilts without translation; one car crosses.
Scene pure_rotation_scene(const Variation& variation) {
  Scene scene = quiet_street(variation.seed(35));
  add_parked_vehicles(scene, variation);
  scene.actors.push_back(driven_vehicle(variation, VehicleKind::kSedan, 84, GroundPath(Points{{-1.8, 60}, {-1.8, -60}}),
                                        SpeedProfile({{0.0, 6.0}}), 0.0));
  const Se3 stand = stand_at(kLane_m, 0.0)(0.0);
  scene.T_scene_cam = [stand](double time_s) {
    const Eigen::Vector3d turn(0.06 * std::sin(1.7 * time_s), 0.45 * std::sin(0.9 * time_s),
                               0.05 * std::sin(1.3 * time_s));
    return stand * Se3{so3_exp(turn), Eigen::Vector3d::Zero()};
  };
  return scene;
}

// A truck passes so close that for some time it covers almost the whole image.
Scene object_fills_image_scene(const Variation& variation) {
  Scene scene = quiet_street(variation.seed(37));
  add_parked_vehicles(scene, variation);
  scene.actors.push_back(driven_vehicle(variation, VehicleKind::kTruck, 85,
                                        GroundPath(Points{{-40, 59.2}, {-10, 59.2}, {40, 59.2}, {80, 59.2}}),
                                        SpeedProfile({{0.0, 5.5}, {3.0, 3.0}, {8.0, 4.5}}), 32.0));
  const Sway sway{{0.002, 0.002, 0.002}, {0.004, 0.004, 0.004}, 0.4, 2.5, variation.seed(39)};
  scene.T_scene_cam = mounted(drive(GroundPath(Points{{1.8, 40}, {1.8, 55.2}, {1.8, 70}}),
                                    SpeedProfile({{0.0, 1.2}, {2.5, 0.3}, {6.5, 0.3}, {9.0, 2.0}}), 12.0),
                              1.65, 0.0, sway);
  return scene;
}

// Nothing moves, not even the rig: only noise changes.
Scene static_scene(const Variation& variation) {
  Scene scene = quiet_street(variation.seed(41));
  add_parked_vehicles(scene, variation);
  scene.T_scene_cam = stand_at(kLane_m, 2.0);
  return scene;
}

}  // namespace kinetrace::simulator
