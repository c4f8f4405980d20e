#include "world/scenery.hpp"

#include <algorithm>

#include "util/random.hpp"

namespace kinetrace::simulator {
namespace {

using Eigen::Vector3f;

// Marks on the street lie slightly above it, so that rays hit them first.
constexpr float kLayer_m = 0.004F;

float uniform(Random& random, double low, double high) {
  return static_cast<float>(random.uniform(low, high));
}

// The slopes and gable ends of a roof whose ridge runs along x; turned by the caller if need be.
Mesh gabled_roof(float length, float depth, float rise, std::uint16_t seed) {
  constexpr float kEaves_m = 0.35F;
  const float a = 0.5F * length + 0.2F;
  const float b = 0.5F * depth + kEaves_m;
  const float low = rise * kEaves_m / (0.5F * depth);
  const Paint tiles{Material::kRoofTiles, seed};
  Mesh roof;
  roof.add_quad({-a, low, -b}, {a, low, -b}, {a, -rise, 0.F}, {-a, -rise, 0.F}, tiles);
  roof.add_quad({a, low, b}, {-a, low, b}, {-a, -rise, 0.F}, {a, -rise, 0.F}, tiles);
  for (const float x : {-0.5F * length, 0.5F * length}) {
    roof.add_triangle({x, 0.F, -0.5F * depth}, {x, 0.F, 0.5F * depth}, {x, -rise, 0.F}, {Material::kWood, seed});
  }
  roof.add_box({0.25F * length, -rise, 0.F}, {0.5F, 1.2F, 0.6F}, {Material::kConcrete, seed});
  return roof;
}

}  // namespace

void add_ground(Mesh& mesh, const GroundArea& area, float height_m, const Paint& paint) {
  const float y = -height_m;
  mesh.add_quad({area.x0, y, area.z0}, {area.x1, y, area.z0}, {area.x1, y, area.z1}, {area.x0, y, area.z1}, paint);
}

void add_slab(Mesh& mesh, const GroundArea& area, float height_m, const Paint& top, const Paint& sides) {
  add_ground(mesh, area, height_m, top);
  const Vector3f a(area.x0, 0.F, area.z0);
  const Vector3f b(area.x1, 0.F, area.z0);
  const Vector3f c(area.x1, 0.F, area.z1);
  const Vector3f d(area.x0, 0.F, area.z1);
  const Vector3f up(0.F, -height_m, 0.F);
  mesh.add_quad(a, b, b + up, a + up, sides);
  mesh.add_quad(b, c, c + up, b + up, sides);
  mesh.add_quad(c, d, d + up, c + up, sides);
  mesh.add_quad(d, a, a + up, d + up, sides);
}

void add_lane_marks(Mesh& mesh, float x, float z0, float z1, float dash_m, float gap_m) {
  for (float z = z0; z < z1; z += dash_m + gap_m) {
    add_ground(mesh, {x - 0.07F, x + 0.07F, z, std::min(z + dash_m, z1)}, kLayer_m, {Material::kRoadMark});
  }
}

void add_crosswalk(Mesh& mesh, float x0, float x1, float z) {
  for (float x = x0; x + 0.5F <= x1; x += 1.F) {
    add_ground(mesh, {x, x + 0.5F, z - 1.6F, z + 1.6F}, kLayer_m, {Material::kRoadMark});
  }
}

void add_road_wear(Mesh& mesh, const GroundArea& area, int count, std::uint32_t seed) {
  for (int i = 0; i < count; ++i) {
    Random random(seed, i, 11);
    const float x = uniform(random, area.x0 + 1.0, area.x1 - 1.0);
    const float z = uniform(random, area.z0, area.z1);
    const auto variant = static_cast<std::uint16_t>(random.bits());
    // Each at its own height, so that overlaps have a defined order.
    const float layer = 0.5F * kLayer_m * (1.F + 0.9F * static_cast<float>(i) / static_cast<float>(count));
    if (random.chance(0.3)) {
      mesh.add_cylinder({x, 0.F, z}, {x, -layer, z}, 0.33F, 0.33F, 24, {Material::kManhole, variant});
    } else {
      const float wide = uniform(random, 0.3, 1.3);
      const float deep = uniform(random, 0.4, 3.5);
      add_ground(mesh, {x - wide, x + wide, z - deep, z + deep}, layer, {Material::kPatch, variant});
    }
  }
}

void add_building(Mesh& mesh, const GroundArea& area, float height_m, bool gabled, std::uint16_t seed) {
  Random random(seed, 21);
  const Vector3f middle(0.5F * (area.x0 + area.x1), 0.F, 0.5F * (area.z0 + area.z1));
  const float wide = area.x1 - area.x0;
  const float deep = area.z1 - area.z0;
  const Material wall = random.chance(0.45) ? Material::kBrickFacade : Material::kPlasterFacade;
  const Vector3f up(0.F, -1.F, 0.F);
  mesh.add_box(middle + up * (0.5F * height_m), {wide, height_m, deep}, {wall, seed});
  // Ledges between the storeys and a plinth.
  const Paint stone{Material::kConcrete, seed};
  mesh.add_box(middle + up * 0.3F, {wide + 0.12F, 0.6F, deep + 0.12F}, stone);
  mesh.add_box(middle + up * (height_m - 0.12F), {wide + 0.5F, 0.24F, deep + 0.5F}, stone);
  if (random.chance(0.6)) {
    mesh.add_box(middle + up * 3.45F, {wide + 0.2F, 0.16F, deep + 0.2F}, stone);
  }
  if (gabled) {
    const bool along_x = wide > deep;
    const float rise = 0.4F * std::min(wide, deep);
    mesh.append(gabled_roof(std::max(wide, deep), std::min(wide, deep), rise, seed), turned(along_x ? 0.F : 1.5707963F),
                middle + up * height_m);
  }
}

void add_tree(Mesh& mesh, float x, float z, float height_m, std::uint16_t seed) {
  constexpr float kHeadroom_m = 2.2F;
  Random random(seed, 31);
  const Vector3f foot(x, 0.F, z);
  const Vector3f fork(x + uniform(random, -0.2, 0.2), -0.45F * height_m, z + uniform(random, -0.2, 0.2));
  mesh.add_cylinder(foot, fork, 0.035F * height_m, 0.02F * height_m, 10, {Material::kBark, seed});
  for (int i = 0; i < 9; ++i) {
    const float spread = 0.2F * height_m;
    Vector3f offset(uniform(random, -1, 1) * spread, -uniform(random, 0.05, 0.45) * height_m,
                    uniform(random, -1, 1) * spread);
    const float radius = uniform(random, 0.1, 0.17) * height_m;
    // Headroom for pedestrians.
    offset.y() = std::min(offset.y(), -fork.y() - kHeadroom_m - radius);
    mesh.add_cylinder(fork, fork + 0.8F * offset, 0.012F * height_m, 0.005F * height_m, 6, {Material::kBark, seed});
    mesh.add_ellipsoid(fork + offset, {radius, 0.8F * radius, radius}, 10,
                       {Material::kFoliage, static_cast<std::uint16_t>(seed * 16 + i)}, 0.22F);
  }
}

void add_hedge(Mesh& mesh, const GroundArea& area, float height_m, std::uint16_t seed) {
  Random random(seed, 41);
  const float x = 0.5F * (area.x0 + area.x1);
  const float half = 0.5F * (area.x1 - area.x0);
  for (float z = area.z0; z < area.z1; z += 1.1F) {
    mesh.add_ellipsoid({x + uniform(random, -0.1, 0.1), -0.48F * height_m, z},
                       {half, 0.58F * height_m * uniform(random, 0.9, 1.1), 0.95F}, 9,
                       {Material::kFoliage, static_cast<std::uint16_t>(random.bits())}, 0.14F);
  }
}

void add_lamp(Mesh& mesh, float x, float z, float reach_m, std::uint16_t seed) {
  const Paint paint{Material::kMetal, seed};
  const Vector3f top(x, -7.2F, z);
  mesh.add_cylinder({x, 0.F, z}, {x, -1.F, z}, 0.12F, 0.11F, 12, paint);
  mesh.add_cylinder({x, -1.F, z}, top, 0.08F, 0.055F, 12, paint);
  mesh.add_cylinder(top, {x + reach_m, -7.7F, z}, 0.045F, 0.04F, 8, paint);
  mesh.add_box({x + reach_m, -7.68F, z}, {0.7F, 0.14F, 0.28F}, {Material::kConcrete, seed});
  mesh.add_box({x, -2.4F, z - 0.09F}, {0.42F, 0.6F, 0.02F}, {Material::kSign, seed});
}

void add_sign(Mesh& mesh, float x, float z, std::uint16_t seed) {
  mesh.add_cylinder({x, 0.F, z}, {x, -2.9F, z}, 0.035F, 0.035F, 8, {Material::kMetal, seed});
  mesh.add_box({x, -2.5F, z - 0.04F}, {0.65F, 0.75F, 0.02F}, {Material::kSign, seed});
}

void add_fence(Mesh& mesh, float x, float z0, float z1, std::uint16_t seed) {
  const Paint paint{Material::kMetal, seed};
  for (float z = z0; z < z1; z += 2.F) {
    mesh.add_box({x, -0.55F, z}, {0.07F, 1.1F, 0.07F}, paint);
  }
  for (const float height : {0.35F, 0.7F, 1.05F}) {
    mesh.add_box({x, -height, 0.5F * (z0 + z1)}, {0.04F, 0.06F, z1 - z0}, paint);
  }
}

}  // namespace kinetrace::simulator
