// Surroundings of the vehicles and people of scene `varied`.
#include <array>
#include <cmath>
#include <utility>

#include "scenes/street_kit.hpp"
#include "scenes/varied_site.hpp"
#include "world/clutter.hpp"
#include "world/scenery.hpp"

namespace kinetrace::simulator {
namespace {

using Eigen::Vector3f;

Paint any_ground(Random& random, double paved) {
  constexpr std::array<Material, 4> kPaved{Material::kAsphalt, Material::kConcrete, Material::kSidewalk,
                                           Material::kPlain};
  constexpr std::array<Material, 4> kOpen{Material::kGrass, Material::kGravel, Material::kFoliage, Material::kConcrete};
  const auto& materials = random.chance(paved) ? kPaved : kOpen;
  const auto which = static_cast<std::size_t>(random.chance(0.55) ? 0 : random.index(4));
  return {materials[which], seed_of(random), nullptr, std::exp(uniform(random, -0.6, 1.0))};
}

// Doors and garages on the wall towards the street.
void add_doors(Site& site, float side, float wall_x, float z0, float z1) {
  constexpr std::array<Material, 5> kLeaves{Material::kWood, Material::kPlain, Material::kMetal, Material::kPanelWall,
                                            Material::kTruckBox};
  Random& random = site.random;
  float z = z0 + uniform(random, 0.5, 2.0);
  while (z < z1 - 3.F) {
    const bool garage = random.chance(0.4);
    const float wide = garage ? uniform(random, 2.0, 2.9) : uniform(random, 0.8, 1.3);
    const float tall = uniform(random, 1.9, 2.4);
    const Paint paint{kLeaves[static_cast<std::size_t>(random.index(kLeaves.size()))], seed_of(random), nullptr,
                      random_tone(random)};
    site.scene.world.add_box({side * (wall_x - 0.03F), -static_cast<float>(site.curb_m) - 0.5F * tall, z + 0.5F * wide},
                             {0.16F, tall, wide}, paint);
    z += uniform(random, 2.6, 7.0);
  }
}

void add_house(Site& site, float side, float z0, float z1) {
  Random& random = site.random;
  const float front =
      static_cast<float>(site.edge_m + site.walk_m) + (random.chance(0.4) ? 0.3F : uniform(random, 1.0, 9.0));
  const float deep = uniform(random, 6.0, 11.0);
  const GroundArea area =
      side > 0.F ? GroundArea{front, front + deep, z0, z1} : GroundArea{-front - deep, -front, z0, z1};
  if (!site.ground.take_if_free({area.x0 - 0.3F, area.x1 + 0.3F, area.z0 - 0.3F, area.z1 + 0.3F})) {
    return;
  }
  Mesh house;
  add_building(house, area, uniform(random, 2.6, 12.0), random.chance(0.7), seed_of(random));
  site.scene.world.append(toned(std::move(house), std::exp(uniform(random, -0.8, 0.7))), Eigen::Matrix3f::Identity(),
                          {0.F, -static_cast<float>(site.curb_m), 0.F});
  add_doors(site, side, front, z0, z1);
}

// A tree, if there is room for it; its crown may hang over the road.
void add_tree_at(Site& site, float x, float z) {
  Random& random = site.random;
  const float tall = uniform(random, 3.5, 13.0);
  const float reach = 0.4F * tall;
  const double trunk_m = 0.06 * static_cast<double>(tall) + 0.2;
  if (!site.heights.is_free({x - reach, x + reach, z - reach, z + reach}) ||
      !site.ground.take_if_free(around(x, z, trunk_m, trunk_m))) {
    return;
  }
  Mesh tree;
  add_tree(tree, 0.F, 0.F, tall, seed_of(random));
  site.scene.world.append(toned(std::move(tree), std::exp(uniform(random, -1.4, 0.5))),
                          turned(uniform(random, -3.0, 3.0)), {x, -static_cast<float>(site.height_m(x)), z});
}

// Along the sidewalk's far side.
void add_border(Site& site, float side, float z0, float z1) {
  Random& random = site.random;
  const float x = static_cast<float>(site.edge_m + site.walk_m) + 0.6F;
  const int kind = random.index(4);
  if (kind == 3 || !site.ground.take_if_free({side * x - 0.6F, side * x + 0.6F, z0, z1})) {
    return;
  }
  Mesh border;
  const GroundArea area{side * x - 0.5F, side * x + 0.5F, z0, z1};
  if (kind == 0) {
    add_hedge(border, area, uniform(random, 0.7, 3.5), seed_of(random));
  } else if (kind == 1) {
    add_fence(border, side * x, z0, z1, seed_of(random));
  } else {
    const float tall = uniform(random, 0.4, 2.2);
    border.add_box({side * x, -0.5F * tall, 0.5F * (z0 + z1)}, {0.25F, tall, z1 - z0},
                   {random.chance(0.5) ? Material::kConcrete : Material::kWood, seed_of(random)});
  }
  site.scene.world.append(toned(std::move(border), random_tone(random)), Eigen::Matrix3f::Identity(),
                          {0.F, -static_cast<float>(site.curb_m), 0.F});
}

// Thickets and houses behind the first row.
void add_backdrop(Site& site, float side) {
  Random& random = site.random;
  const double green = random.unit();
  float z = Site::kFarBegin_m;
  while (z < Site::kFarEnd_m) {
    const float x = static_cast<float>(site.edge_m + site.walk_m) + uniform(random, 24.0, 40.0);
    const auto seed = seed_of(random);
    Mesh thing;
    if (random.chance(green)) {
      const float radius = uniform(random, 2.5, 8.0);
      thing.add_ellipsoid({0.F, -0.6F * radius, 0.F}, {radius, radius, radius}, 12, {Material::kFoliage, seed}, 0.2F);
    } else {
      add_building(thing, {-6.F, 6.F, -5.F, 5.F}, uniform(random, 4.0, 15.0), random.chance(0.7), seed);
    }
    site.scene.world.append(toned(std::move(thing), random_tone(random)), Eigen::Matrix3f::Identity(),
                            {side * x, -static_cast<float>(site.curb_m), z});
    z += uniform(random, 4.0, 15.0);
  }
}

}  // namespace

void add_surfaces(Site& site) {
  Random& random = site.random;
  Mesh& mesh = site.scene.world;
  const auto road = static_cast<float>(site.edge_m);
  const auto walk = static_cast<float>(site.walk_m);
  const auto curb = static_cast<float>(site.curb_m);
  const float z0 = 2.F * Site::kFarBegin_m;
  const float z1 = 2.F * Site::kFarEnd_m;
  add_ground(mesh, {-road, road, z0, z1}, 0.F, any_ground(random, 0.93));
  const Paint paving = any_ground(random, 0.9);
  const Paint stone{Material::kCurb, 0, nullptr, std::exp(uniform(random, -0.6, 0.5))};
  const Paint yard = any_ground(random, 0.3);
  for (const float side : {-1.F, 1.F}) {
    const auto area = [&](float from, float to) {
      return side > 0.F ? GroundArea{from, to, z0, z1} : GroundArea{-to, -from, z0, z1};
    };
    add_slab(mesh, area(road, road + walk), curb, paving, stone);
    add_ground(mesh, area(road + walk, road + 150.F), curb, yard);
  }
  const auto half = static_cast<float>(site.half_road_m);
  Mesh marks;
  if (random.chance(0.6)) {
    add_lane_marks(marks, uniform(random, -0.3, 0.3) * half, z0, z1, uniform(random, 1.0, 8.0),
                   uniform(random, 0.0, 6.0));
  }
  if (random.chance(0.4)) {
    add_lane_marks(marks, -half, z0, z1, 5.F, 0.2F);
    add_lane_marks(marks, half, z0, z1, 5.F, 0.2F);
  }
  if (random.chance(0.3)) {
    add_crosswalk(marks, -half, half, uniform(random, 5.0, 40.0));
  }
  mesh.append(toned(std::move(marks), uniform(random, 0.7, 1.7)), Eigen::Matrix3f::Identity(), Vector3f::Zero());
  Mesh wear;
  add_road_wear(wear, {-half, half, -20.F, 80.F}, random.index(40), random.bits());
  mesh.append(toned(std::move(wear), random_tone(random)), Eigen::Matrix3f::Identity(), Vector3f::Zero());
}

void add_roadside(Site& site, float side) {
  Random& random = site.random;
  const double built = random.unit();
  const double bordered = random.unit();
  float z = Site::kFarBegin_m;
  while (z < Site::kFarEnd_m) {
    const float length = uniform(random, 6.0, 17.0);
    const auto beside = [&] {
      return side * (static_cast<float>(site.edge_m + site.walk_m) + uniform(random, 0.5, 12.0));
    };
    if (random.chance(built)) {
      add_house(site, side, z, z + length);
    }
    if (random.chance(bordered)) {
      add_border(site, side, z + 0.5F, z + length - 0.5F);
    }
    for (int i = random.index(5); i > 0; --i) {
      add_tree_at(site, beside(), z + uniform(random, 0.0, static_cast<double>(length)));
    }
    if (random.chance(0.4)) {
      add_tree_at(site, side * (static_cast<float>(site.edge_m) + 0.6F), z + 0.5F * length);
    }
    z += length + (random.chance(0.5) ? 0.F : uniform(random, 0.5, 5.0));
  }
  add_backdrop(site, side);
  // The end of the view.
  float at = 4.F;
  while (at < 90.F) {
    Mesh far;
    add_building(far, {side * at - 4.5F, side * at + 4.5F, Site::kFarEnd_m + 60.F, Site::kFarEnd_m + 70.F},
                 uniform(random, 5.0, 20.0), random.chance(0.5), seed_of(random));
    site.scene.world.append(toned(std::move(far), random_tone(random)), Eigen::Matrix3f::Identity(), Vector3f::Zero());
    at += uniform(random, 9.0, 20.0);
  }
}

void add_clutter(Site& site) {
  Random& random = site.random;
  for (int i = random.index(70); i > 0; --i) {
    const Clutter thing = random_clutter(random);
    const double reach_m = static_cast<double>(thing.half_m.maxCoeff());
    const double x_m = random.chance(0.12) ? random.uniform(-1.0, 1.0) * site.half_road_m
                                           : site.side() * (site.edge_m + 0.2 + reach_m + random.uniform(0.0, 7.0));
    const double z_m = random.uniform(Site::kBegin_m, Site::kEnd_m);
    const GroundArea area = around(x_m, z_m, 1.45 * reach_m, 1.45 * reach_m);
    if (site.heights.is_free(area) && site.ground.take_if_free(area)) {
      site.scene.world.append(
          thing.mesh, turned(uniform(random, -3.0, 3.0)),
          {static_cast<float>(x_m), -static_cast<float>(site.height_m(x_m)), static_cast<float>(z_m)});
    }
  }
}

}  // namespace kinetrace::simulator
