// Streets as diverse as possible, for training networks: any vehicles, people, clutter, ground, light and camera, so
// that only the appearance of vehicles and people is common to all pictures (Tobin et al., "Domain randomization for
// transferring deep neural networks from simulation to the real world", 2017; Prakash et al., "Structured domain
// randomization", 2019).
#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

#include "scenes/scenes.hpp"
#include "scenes/street_kit.hpp"
#include "scenes/varied_site.hpp"
#include "util/random.hpp"
#include "world/people.hpp"
#include "world/random_vehicle.hpp"
#include "world/scenery.hpp"

namespace kinetrace::simulator {
namespace {
using Eigen::Vector3f;

constexpr int kFrames = 16;
constexpr int kViewsOfEach = 4;  // Of each of the cameras' places.

void draw_light(Site& site) {
  Random& random = site.random;
  Light& light = site.scene.light;
  const bool overcast = random.chance(0.2);
  light.sun = overcast ? uniform(random, 0.0, 0.3) : std::exp(uniform(random, -0.7, 0.7));
  light.ambient = overcast ? uniform(random, 0.4, 0.8) : std::exp(uniform(random, -2.8, -0.7));
  light.sky = std::exp(uniform(random, -0.7, 0.9));
  light.exposure = uniform(random, 0.4, 1.4) / (0.4F * light.sun + light.ambient);
  const double azimuth_rad = random.uniform(-std::numbers::pi, std::numbers::pi);
  const double rise = random.uniform(0.25, 1.6);
  light.to_sun = Vector3f(static_cast<float>(std::sin(azimuth_rad)), -static_cast<float>(rise),
                          static_cast<float>(std::cos(azimuth_rad)));
}

void draw_rig(Site& site) {
  site.scene.rig = car_rig();
  const double zoom = std::exp(site.random.uniform(-0.45, 0.4));
  site.scene.rig.fx_px *= zoom;
  site.scene.rig.fy_px *= zoom;
  site.scene.rig.cy_px += site.random.uniform(-30.0, 40.0);
}

// A few camera positions, each with several directions.
void place_cameras(Site& site) {
  constexpr int kPlaces = 9;
  constexpr double kClear_m = 1.3;
  Random& random = site.random;
  for (int i = 0; i < kPlaces; ++i) {
    const double x_m = random.chance(0.2) ? site.side() * (site.edge_m + 0.5 * site.walk_m)
                                          : random.uniform(-0.8, 0.8) * site.half_road_m;
    const double z_m = random.uniform(-8.0, 40.0);
    site.ground.take(around(x_m, z_m, kClear_m, kClear_m));
    site.heights.take(around(x_m, z_m, kClear_m, kClear_m));
    for (int view = 0; view < kViewsOfEach; ++view) {
      double heading_rad = (random.chance(0.75) ? kAlongZ_rad : kAgainstZ_rad) + 0.2 * random.normal();
      if (random.chance(0.15)) {
        heading_rad = random.uniform(-std::numbers::pi, std::numbers::pi);
      }
      const double height_m = random.chance(0.7) ? random.uniform(1.2, 2.2) : random.uniform(0.6, 3.0);
      const double pitch_rad = random.uniform(-0.07, 0.03) + 0.05 * height_m * random.unit();
      const Se3 level = mounted(parked(x_m, z_m, heading_rad), height_m + site.height_m(x_m), pitch_rad, {})(0.0);
      site.views.push_back(level * Se3{so3_exp({0.0, 0.0, 0.03 * random.normal()}), Eigen::Vector3d::Zero()});
    }
  }
}

// True if the vehicle was placed: the space is free, and not on a curb.
bool place_vehicle(Site& site, const RandomVehicle& made, double x_m, double z_m, double heading_rad) {
  constexpr double kApart_m = 0.14;
  constexpr float kLow_m = 2.F;
  const Eigen::Vector3d half_m = 0.5 * made.size_lhw_m.cast<double>();
  const double c = std::abs(std::cos(heading_rad));
  const double s = std::abs(std::sin(heading_rad));
  const double half_x_m = half_m.x() * c + half_m.z() * s + kApart_m;
  const GroundArea area = around(x_m, z_m, half_x_m, half_m.x() * s + half_m.z() * c + kApart_m);
  const bool on_curb = std::abs(std::abs(x_m) - site.edge_m) < half_x_m;
  if (on_curb || !site.has_room() || !site.ground.take_if_free(area)) {
    return false;
  }
  if (made.size_lhw_m.y() > kLow_m) {
    site.heights.take(area);
  }
  Actor actor;
  actor.size_lhw_m = made.size_lhw_m.cast<double>();
  actor.parts.push_back(made.mesh);
  actor.shape = made.shape;
  actor.T_scene_obj = raised(parked(x_m, z_m, heading_rad), site.height_m(x_m));
  if (made.doorway_m) {
    const Eigen::Vector2d doorway = made.doorway_m->cast<double>();
    const Eigen::Vector3d at = actor.T_scene_obj(0.0) * Eigen::Vector3d(doorway.x(), 0.0, doorway.y());
    site.doorways.emplace_back(at.x(), at.z());
  }
  site.scene.actors.push_back(std::move(actor));
  return true;
}

double along_street(Site& site) {
  return site.random.chance(0.5) ? kAlongZ_rad : kAgainstZ_rad;
}

// A row at the curb, one behind the other.
void park_along(Site& site, double side) {
  Random& random = site.random;
  const double sparse_m = random.chance(0.6) ? random.uniform(0.5, 2.0) : random.uniform(2.0, 16.0);
  const double usual_rad = along_street(site);
  double z_m = Site::kBegin_m + random.uniform(0.0, 5.0);
  while (z_m < Site::kEnd_m && site.scene.actors.size() < site.max_vehicles) {
    const RandomVehicle made = random_vehicle(random);
    const double half_m = 0.5 * static_cast<double>(made.size_lhw_m.x());
    const double heading_rad = (random.chance(0.85) ? usual_rad : along_street(site)) + 0.02 * random.normal();
    const double reach_m = 0.5 * static_cast<double>(made.size_lhw_m.z()) + half_m * std::abs(std::cos(heading_rad));
    const double x_m = site.edge_m - reach_m - random.uniform(0.2, 0.45);
    place_vehicle(site, made, side * x_m, z_m + half_m, heading_rad);
    z_m += 2.0 * half_m + 0.5 + sparse_m * random.unit();
  }
}

// A row across the strip, one beside the other.
void park_across(Site& site, double side) {
  Random& random = site.random;
  const double gap_m = random.uniform(0.5, 1.2);
  double z_m = Site::kBegin_m + random.uniform(0.0, 5.0);
  while (z_m < Site::kEnd_m && site.scene.actors.size() < site.max_vehicles) {
    const RandomVehicle made = random_vehicle(random);
    const double heading_rad = random.chance(0.5) ? 0.0 : std::numbers::pi;
    const double half_m = 0.5 * static_cast<double>(made.size_lhw_m.z());
    const double x_m = site.edge_m - 0.5 * static_cast<double>(made.size_lhw_m.x()) - random.uniform(0.2, 0.6);
    if (made.size_lhw_m.x() < 6.F && random.chance(0.85)) {
      place_vehicle(site, made, side * x_m, z_m + half_m, heading_rad);
    }
    z_m += 2.0 * half_m + gap_m;
  }
}

void add_vehicles(Site& site, const std::array<double, 2>& strips_m) {
  Random& random = site.random;
  // On the road first: vehicles there are rarer.
  for (int i = random.index(9); i > 0; --i) {
    const double heading_rad = random.chance(0.75) ? along_street(site) + 0.06 * random.normal()
                                                   : random.uniform(-std::numbers::pi, std::numbers::pi);
    place_vehicle(site, random_vehicle(random), random.uniform(-0.8, 0.8) * site.half_road_m,
                  random.uniform(Site::kBegin_m, Site::kEnd_m), heading_rad);
  }
  for (const std::size_t i : {0U, 1U}) {
    const double side = i == 0 ? -1.0 : 1.0;
    if (strips_m[i] > 4.0) {
      park_across(site, side);
    } else if (strips_m[i] > 0.0) {
      park_along(site, side);
    }
  }
  // In front of houses.
  for (int i = random.index(7); i > 0; --i) {
    const double heading_rad =
        random.chance(0.7) ? 0.1 * random.normal() + (random.chance(0.5) ? std::numbers::pi : 0.0) : along_street(site);
    place_vehicle(site, random_vehicle(random), site.side() * (site.edge_m + site.walk_m + random.uniform(1.0, 7.0)),
                  random.uniform(Site::kBegin_m, Site::kEnd_m), heading_rad);
  }
}

// Vehicles close to the cameras, half of them tall: most of one fills a quarter of the picture or more, and leaves it.
void add_vehicles_in_view(Site& site) {
  constexpr double kOfPlaces = 0.6;
  constexpr double kNearest_m = 2.5;
  constexpr double kFarthest_m = 9.0;
  constexpr double kBearing_rad = 0.7;
  constexpr float kTall_m = 2.F;
  constexpr int kTries = 6;
  Random& random = site.random;
  for (std::size_t view = 0; view < site.views.size(); view += kViewsOfEach) {
    if (!random.chance(kOfPlaces)) {
      continue;
    }
    RandomVehicle made = random_vehicle(random);
    for (int i = random.chance(0.5) ? kTries : 0; i > 0 && made.size_lhw_m.y() < kTall_m; --i) {
      made = random_vehicle(random);
    }
    bool placed = false;
    for (int i = 0; i < kTries && !placed; ++i) {
      const double range_m = std::exp(random.uniform(std::log(kNearest_m), std::log(kFarthest_m)));
      const double bearing_rad = random.uniform(-kBearing_rad, kBearing_rad);
      const Eigen::Vector3d at =
          site.views[view] * Eigen::Vector3d(range_m * std::sin(bearing_rad), 0.0, range_m * std::cos(bearing_rad));
      const double heading_rad = random.chance(0.8) ? along_street(site) + 0.06 * random.normal()
                                                    : random.uniform(-std::numbers::pi, std::numbers::pi);
      placed = place_vehicle(site, made, at.x(), at.z(), heading_rad);
    }
  }
}

// A person who walks or stands there.
void place_person(Site& site, double x_m, double z_m) {
  constexpr double kStanding_m = 0.54;  // In any orientation.
  constexpr double kWalking_m = 0.36;
  Random& random = site.random;
  const double height_m = random.chance(0.8) ? random.uniform(1.5, 1.95) : random.uniform(1.0, 1.5);
  const double heading_rad = random.uniform(-std::numbers::pi, std::numbers::pi);
  if (!site.has_room() || std::abs(std::abs(x_m) - site.edge_m) < 0.5) {
    return;
  }
  if (random.chance(0.5)) {
    if (site.ground.take_if_free(around(x_m, z_m, kStanding_m, kStanding_m))) {
      const auto shoulder = [&] { return random.chance(0.5) ? random.uniform(-0.2, 0.3) : random.uniform(-0.3, 1.5); };
      const auto elbow = [&] { return random.chance(0.5) ? random.uniform(0.0, 0.4) : random.uniform(0.0, 2.0); };
      const double lean_rad = random.chance(0.7) ? random.uniform(-0.05, 0.1) : random.uniform(0.1, 0.9);
      const Stance stance{{shoulder(), shoulder()}, {elbow(), elbow()}, lean_rad};
      site.scene.actors.push_back(standing_person(raised(parked(x_m, z_m, heading_rad), site.height_m(x_m)), stance,
                                                  seed_of(random), height_m, random_outfit(random)));
    }
    return;
  }
  // As far as a person walks within the frames.
  const Eigen::Vector2d way_m = 2.5 * Eigen::Vector2d(std::sin(heading_rad), std::cos(heading_rad));
  const Eigen::Vector2d middle_m = Eigen::Vector2d(x_m, z_m) + 0.5 * way_m;
  const Eigen::Vector2d half_m = 0.5 * way_m.cwiseAbs() + Eigen::Vector2d::Constant(kWalking_m);
  const bool crosses_curb = std::abs(std::abs(middle_m.x()) - site.edge_m) < half_m.x();
  if (!crosses_curb && site.ground.take_if_free(around(middle_m.x(), middle_m.y(), half_m.x(), half_m.y()))) {
    Actor walker = walking_person(GroundPath({{x_m, z_m}, {x_m + way_m.x(), z_m + way_m.y()}}),
                                  SpeedProfile({{0.0, random.uniform(0.5, 1.5)}}), 0.0, seed_of(random), height_m,
                                  Arms::kSwinging, random_outfit(random));
    walker.T_scene_obj = raised(std::move(walker.T_scene_obj), site.height_m(x_m));
    site.scene.actors.push_back(std::move(walker));
  }
}

// People in front of the cameras; along the street they are mostly far away, a few pixels tall.
void add_people_in_view(Site& site) {
  constexpr double kNearest_m = 3.5;
  constexpr double kFarthest_m = 22.0;
  constexpr double kBearing_rad = 0.6;
  Random& random = site.random;
  for (const Se3& view : site.views) {
    if (random.chance(0.5)) {
      continue;
    }
    const double range_m = std::exp(random.uniform(std::log(kNearest_m), std::log(kFarthest_m)));
    const double bearing_rad = random.uniform(-kBearing_rad, kBearing_rad);
    const Eigen::Vector3d at =
        view * Eigen::Vector3d(range_m * std::sin(bearing_rad), 0.0, range_m * std::cos(bearing_rad));
    place_person(site, at.x(), at.z());
  }
}

void add_people(Site& site) {
  Random& random = site.random;
  const std::size_t vehicles = site.scene.actors.size();
  for (const Eigen::Vector2d& doorway : site.doorways) {
    if (random.chance(0.75)) {
      place_person(site, doorway.x(), doorway.y());
    }
  }
  add_people_in_view(site);
  for (int i = 4 + random.index(12); i > 0; --i) {
    double x_m = site.side() * (site.edge_m + random.uniform(0.5, 1.0) * site.walk_m);
    double z_m = random.uniform(Site::kBegin_m, Site::kEnd_m);
    if (random.chance(0.3)) {
      x_m = random.uniform(-0.9, 0.9) * site.half_road_m;
    } else if (vehicles > 0 && random.chance(0.4)) {
      // Beside a vehicle, on the road's side of it.
      const Actor& car = site.scene.actors[static_cast<std::size_t>(random.index(static_cast<int>(vehicles)))];
      const Eigen::Vector3d at = car.T_scene_obj(0.0).translation;
      x_m = at.x() - std::copysign(0.5 * car.size_lhw_m.z() + 0.5, at.x());
      z_m = at.z() + random.uniform(-0.5, 0.5) * car.size_lhw_m.x();
    }
    place_person(site, x_m, z_m);
    for (int company = random.chance(0.35) ? 1 + random.index(4) : 0; company > 0; --company) {
      place_person(site, x_m + random.uniform(-1.2, 1.2), z_m + random.uniform(-1.2, 1.2));
    }
  }
}
double any_strip_m(Random& random) {
  const double kind = random.unit();
  if (kind < 0.2) {
    return 0.0;
  }
  return kind < 0.85 ? random.uniform(2.2, 3.0) : random.uniform(5.0, 6.0);
}

}  // namespace

Scene varied_scene(const Variation& variation) {
  // The camera jumps from view to view, at least once a frame at any pace.
  constexpr double kViews_hz = 20.0;
  Site site(variation.seed(91));
  const std::array<double, 2> strips_m{any_strip_m(site.random), any_strip_m(site.random)};
  site.half_road_m = site.random.uniform(2.2, 7.0);
  site.edge_m = site.half_road_m + std::max(strips_m[0], strips_m[1]);
  site.walk_m = site.random.uniform(0.8, 4.0);
  site.curb_m = site.random.uniform(0.03, 0.16);
  draw_light(site);
  draw_rig(site);
  place_cameras(site);
  site.max_vehicles = site.random.chance(0.5) ? 44 : 22;
  add_vehicles_in_view(site);
  add_vehicles(site, strips_m);
  add_people(site);
  add_surfaces(site);
  add_clutter(site);
  add_roadside(site, -1.F);
  add_roadside(site, 1.F);
  site.scene.frames = kFrames;
  site.scene.T_scene_cam = [views = std::move(site.views)](double time_s) {
    const auto index = static_cast<std::size_t>(std::max(0.0, time_s) * kViews_hz);
    return views[index % views.size()];
  };
  return std::move(site.scene);
}

}  // namespace kinetrace::simulator
