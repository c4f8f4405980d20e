// One car that recedes from 8 to 80 m: growth of errors with shrinking objects.
#include "scenes/scenes.hpp"
#include "scenes/street_kit.hpp"

namespace kinetrace::simulator {

Scene receding_scene(const Variation& variation) {
  using Points = std::vector<Eigen::Vector2d>;
  constexpr double kLane_m = 5.2;
  Scene scene;
  StreetPlan plan;
  plan.seed = variation.seed(11);
  plan.z1_m = 260.F;
  plan.crossing_z_m = 150.F;
  scene.world = street_world(plan);
  scene.rig = car_rig();
  scene.frames = 150;
  scene.actors.push_back(vehicle(
      VehicleKind::kHatchback, variation.look(81),
      drive(GroundPath(Points{{kLane_m, 0}, {kLane_m, 60}, {kLane_m - 0.4, 110}, {kLane_m, 180}, {kLane_m, 300}}),
            SpeedProfile({{0.0, 8.0}, {4.0, 11.4}, {11.0, 11.4}, {15.0, 11.4}}), 10.1)));
  const Sway sway{{0.003, 0.003, 0.002}, {0.008, 0.01, 0.0}, 0.4, 2.5, variation.seed(15)};
  scene.T_scene_cam = mounted(drive(GroundPath(Points{{kLane_m, -30}, {kLane_m, 60}, {kLane_m, 200}}),
                                    SpeedProfile({{0.0, 6.5}, {6.0, 6.0}}), 30.0),
                              1.65, 0.0, sway);
  return scene;
}

}  // namespace kinetrace::simulator
