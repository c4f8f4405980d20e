// As many objects as Kinetrace tracks at once, vehicles and people, on a large square.
#include "scenes/scenes.hpp"
#include "scenes/street_kit.hpp"
#include "util/random.hpp"
#include "world/people.hpp"

namespace kinetrace::simulator {
namespace {

using Points = std::vector<Eigen::Vector2d>;

VehicleKind small_vehicle(Random& random) {
  return random.chance(0.5) ? VehicleKind::kHatchback : VehicleKind::kSedan;
}

// Rows of parked cars on both sides, seen from their noses or tails.
void add_parking(Scene& scene, const Variation& variation, Random& random) {
  for (const double side : {-1.0, 1.0}) {
    for (int i = 0; i < 12; ++i) {
      const double heading_rad = random.chance(0.5) ? 0.0 : 3.14159;
      scene.actors.push_back(vehicle(small_vehicle(random),
                                     variation.look(static_cast<std::uint16_t>(100 + scene.actors.size())),
                                     parked(side * 13.5, 7.0 + 2.9 * i, heading_rad)));
    }
  }
}

// Lanes along the square, one vehicle behind the other, each lane at its own speed.
void add_traffic(Scene& scene, const Variation& variation, Random& random) {
  struct Lane {
    double x_m;
    double speed_mps;  ///< Negative: towards us.
    int vehicles;
    double first_m;
    double gap_m;
  };
  std::uint32_t key = 0;
  for (const Lane& lane : {Lane{-8.0, -4.0, 4, 30.0, 11.0}, Lane{-4.6, -5.5, 4, 24.0, 13.0},
                           Lane{4.6, 5.0, 4, 9.0, 10.0}, Lane{8.0, 3.5, 4, 14.0, 11.0}}) {
    ++key;
    for (int i = 0; i < lane.vehicles; ++i) {
      const double z = lane.first_m + lane.gap_m * i;
      const double ahead = lane.speed_mps > 0.0 ? 300.0 : -300.0;
      const double speed = std::abs(lane.speed_mps);
      scene.actors.push_back(vehicle(small_vehicle(random),
                                     variation.look(static_cast<std::uint16_t>(200 + scene.actors.size())),
                                     drive(GroundPath(Points{{lane.x_m, z}, {lane.x_m, z + ahead}}),
                                           variation.paced(SpeedProfile({{0.0, speed}, {5.0, 1.1 * speed}}), key))));
    }
  }
}

// People on footpaths between the lanes, where no vehicle goes.
void add_walkers(Scene& scene, const Variation& variation, Random& random) {
  for (int i = 0; scene.actors.size() < static_cast<std::size_t>(kMaxObjects); ++i) {
    constexpr std::array<double, 6> kFootpaths_m{-10.4, -2.6, -1.6, 1.6, 2.6, 10.4};
    const std::size_t footpath = static_cast<std::size_t>(i) % kFootpaths_m.size();
    const double x = kFootpaths_m[footpath];
    const double z = 9.0 + 1.45 * i + random.uniform(0.0, 0.6);
    const double ahead = i % 2 == 0 ? -60.0 : 60.0;
    scene.actors.push_back(walking_person(
        GroundPath(Points{{x, z}, {x, z + ahead}}),
        // No overtaking on a footpath.
        variation.paced(SpeedProfile({{0.0, i % 2 == 0 ? 1.2 : 1.4}}), static_cast<std::uint32_t>(10 + footpath)), 0.0,
        variation.look(static_cast<std::uint16_t>(40 + i)), variation.height_m(static_cast<std::uint32_t>(40 + i))));
  }
}

}  // namespace

Scene crowd_scene(const Variation& variation) {
  Scene scene;
  StreetPlan plan;
  plan.seed = variation.seed(23);
  plan.half_road_m = 10.F;
  plan.parking_m = 6.5F;
  plan.crossing_z_m = 130.F;
  scene.world = street_world(plan);
  scene.rig = car_rig();
  Random random(plan.seed, 1);
  add_parking(scene, variation, random);
  add_traffic(scene, variation, random);
  add_walkers(scene, variation, random);
  const Sway sway{{0.003, 0.004, 0.003}, {0.01, 0.01, 0.01}, 0.4, 2.5, variation.seed(25)};
  scene.T_scene_cam =
      mounted(drive(GroundPath(Points{{0, -10}, {0, 0}, {0.2, 10}, {0, 40}}), SpeedProfile({{0.0, 0.8}}), 10.0), 2.6,
              0.05, sway);
  return scene;
}

}  // namespace kinetrace::simulator
