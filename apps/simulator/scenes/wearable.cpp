// Glasses on a person's head in a hall: fast turns, a short baseline, a trolley pushed past.
#include <cmath>
#include <numbers>

#include "scenes/scenes.hpp"
#include "util/random.hpp"
#include "world/people.hpp"
#include "world/scenery.hpp"

namespace kinetrace::simulator {
namespace {

using Eigen::Vector3f;
using Points = std::vector<Eigen::Vector2d>;

constexpr float kWide_m = 9.F;
constexpr float kLong_m = 16.F;
constexpr float kTall_m = 3.6F;

std::uint16_t variant(Random& random) {
  return static_cast<std::uint16_t>(random.bits());
}

// One wall from `a` to `b` with pictures on it.
void add_wall(Mesh& mesh, const Vector3f& a, const Vector3f& b, std::uint16_t seed) {
  const Vector3f up(0.F, -kTall_m, 0.F);
  mesh.add_quad(a, b, b + up, a + up, {Material::kPanelWall, seed});
  const Vector3f along = (b - a).normalized();
  const Vector3f inward = 0.015F * along.cross(up).normalized();
  Random random(seed, 3);
  const float length = (b - a).norm();
  for (float at = 0.7F; at < length - 1.6F; at += static_cast<float>(random.uniform(1.5, 2.6))) {
    const float wide = static_cast<float>(random.uniform(0.5, 1.1));
    const float tall = static_cast<float>(random.uniform(0.6, 1.2));
    const Vector3f foot = a + at * along + inward + Vector3f(0.F, -static_cast<float>(random.uniform(0.9, 1.4)), 0.F);
    const Vector3f rise(0.F, -tall, 0.F);
    mesh.add_quad(foot, foot + wide * along, foot + wide * along + rise, foot + rise,
                  {Material::kPoster, variant(random)});
  }
}

// Boards on posts, with boxes and books on them, along z at `x`.
void add_shelf(Mesh& mesh, float x, float z, std::uint16_t seed) {
  constexpr float kLength_m = 2.4F;
  constexpr float kDepth_m = 0.45F;
  Random random(seed, 4);
  for (const float height : {0.25F, 0.85F, 1.45F, 2.05F}) {
    mesh.add_box({x, -height, z}, {kDepth_m, 0.03F, kLength_m}, {Material::kWood, seed});
    float at = z - 0.5F * kLength_m + 0.2F;
    while (at < z + 0.5F * kLength_m - 0.25F) {
      const float deep = static_cast<float>(random.uniform(0.15, 0.45));
      const float tall = static_cast<float>(random.uniform(0.15, 0.45));
      mesh.add_box({x, -height - 0.015F - 0.5F * tall, at + 0.5F * deep}, {0.8F * kDepth_m, tall, 0.92F * deep},
                   {random.chance(0.5) ? Material::kCardboard : Material::kPoster, variant(random)});
      at += deep + 0.03F;
    }
  }
  for (const float end : {-0.5F * kLength_m, 0.5F * kLength_m}) {
    mesh.add_box({x, -1.1F, z + end}, {kDepth_m, 2.2F, 0.05F}, {Material::kMetal, seed});
  }
}

Mesh hall(const Variation& variation) {
  Mesh mesh;
  const float half = 0.5F * kWide_m;
  add_ground(mesh, {-half, half, -3.F, kLong_m}, 0.F, {Material::kFloorTiles});
  add_wall(mesh, {-half, 0.F, -3.F}, {-half, 0.F, kLong_m}, variation.look(11));
  add_wall(mesh, {-half, 0.F, kLong_m}, {half, 0.F, kLong_m}, variation.look(12));
  add_wall(mesh, {half, 0.F, kLong_m}, {half, 0.F, -3.F}, variation.look(13));
  add_wall(mesh, {half, 0.F, -3.F}, {-half, 0.F, -3.F}, variation.look(14));
  // An open roof: light falls in stripes.
  for (float z = -2.5F; z < kLong_m; z += 1.9F) {
    mesh.add_box({0.F, -kTall_m - 0.15F, z}, {kWide_m, 0.3F, 0.7F}, {Material::kWood, 5});
  }
  for (int i = 0; i < 4; ++i) {
    add_shelf(mesh, 4.1F, 1.F + 3.2F * static_cast<float>(i), variation.look(static_cast<std::uint16_t>(20 + i)));
    add_shelf(mesh, -4.1F, 3.5F + 3.2F * static_cast<float>(i), variation.look(static_cast<std::uint16_t>(30 + i)));
  }
  for (const float z : {6.5F, 12.F}) {
    mesh.add_box({-1.9F, -0.74F, z}, {0.8F, 0.05F, 1.5F}, {Material::kWood, 9});
    for (const float leg : {-0.65F, 0.65F}) {
      mesh.add_box({-1.9F, -0.36F, z + leg}, {0.7F, 0.72F, 0.05F}, {Material::kWood, 9});
    }
    mesh.add_box({-1.8F, -0.93F, z - 0.3F}, {0.35F, 0.33F, 0.4F},
                 {Material::kCardboard, static_cast<std::uint16_t>(z)});
    mesh.add_box({-2.F, -0.87F, z + 0.35F}, {0.3F, 0.2F, 0.45F}, {Material::kPoster, static_cast<std::uint16_t>(z)});
  }
  return mesh;
}

// A trolley loaded with boxes.
Actor trolley(Trajectory trajectory) {
  Actor actor;
  actor.class_id = kThingClass;
  actor.size_lhw_m = {1.1, 1.15, 0.65};
  Mesh& mesh = actor.parts.emplace_back();
  mesh.add_box({0.F, -0.2F, 0.F}, {1.F, 0.05F, 0.6F}, {Material::kMetal, 71});
  for (const float z : {-0.27F, 0.27F}) {
    mesh.add_cylinder({-0.48F, -0.18F, z}, {-0.52F, -1.08F, z}, 0.02F, 0.02F, 10, {Material::kMetal, 72});
  }
  for (const float height : {0.45F, 0.75F, 1.08F}) {
    mesh.add_cylinder({-0.51F, -height, -0.27F}, {-0.51F, -height, 0.27F}, 0.018F, 0.018F, 10, {Material::kMetal, 72});
  }
  mesh.add_box({0.12F, -0.42F, 0.1F}, {0.6F, 0.4F, 0.4F}, {Material::kCardboard, 73});
  mesh.add_box({-0.27F, -0.38F, -0.08F}, {0.34F, 0.32F, 0.36F}, {Material::kPoster, 74});
  mesh.add_box({0.15F, -0.77F, 0.06F}, {0.45F, 0.3F, 0.35F}, {Material::kCardboard, 75}, turned(0.2F));
  mesh.add_box({0.3F, -0.33F, -0.2F}, {0.3F, 0.22F, 0.18F}, {Material::kPoster, 76});
  for (const float x : {-0.4F, 0.4F}) {
    for (const float z : {-0.24F, 0.24F}) {
      mesh.add_cylinder({x, -0.08F, z - 0.02F}, {x, -0.08F, z + 0.02F}, 0.08F, 0.08F, 12, {Material::kTyre});
      mesh.add_box({x, -0.14F, z}, {0.04F, 0.08F, 0.06F}, {Material::kMetal, 71});
    }
  }
  actor.T_scene_obj = std::move(trajectory);
  return actor;
}

// Head turns: still for a moment, then fast to the other side; up to 100 degrees a second.
double head_yaw_rad(double time_s) {
  const auto turn = [&](double begin_s, double seconds, double angle_rad) {
    const double s = std::clamp((time_s - begin_s) / seconds, 0.0, 1.0);
    return angle_rad * s * s * s * (s * (6.0 * s - 15.0) + 10.0);
  };
  return turn(1.0, 0.8, 0.6) + turn(2.3, 1.2, -1.1) + turn(4.1, 0.7, 0.5) + turn(5.4, 1.0, 0.75) +
         turn(6.9, 1.2, -0.75);
}

}  // namespace

Scene wearable_scene(const Variation& variation) {
  Scene scene;
  scene.world = hall(variation);
  scene.light.to_sun = {0.35F, -0.8F, 0.3F};
  scene.light.ambient = 0.5F;
  scene.light.sky = 0.8F;
  scene.rig = {400.0, 400.0, 319.5, 239.5, 0.10, 640, 480};
  scene.rate_hz = 25.0;
  scene.frames = 200;
  // The trolley approaches and passes on the right; the person who pushes it walks behind.
  const GroundPath path(Points{{0.3, 11.5}, {0.6, 8}, {1.1, 5}, {1.3, 2}, {1.3, -1.5}});
  const SpeedProfile speed = variation.paced(SpeedProfile({{0.0, 0.9}, {3.0, 1.1}, {6.0, 0.8}}), 11);
  scene.actors.push_back(trolley(drive(path, speed, 2.0)));
  scene.actors.push_back(walking_person(path, speed, 1.0, variation.look(11), kPersonHeight_m, Arms::kPushing));
  scene.actors.push_back(trolley(parked(2.6, variation.place_m(9.5, 13), 0.6)));
  scene.actors.push_back(walking_person(GroundPath(Points{{-3.2, 14}, {-3.0, 3}}),
                                        variation.paced(SpeedProfile({{0.0, 0.7}}), 12), 3.0, variation.look(12),
                                        variation.height_m(12)));
  const Trajectory walk = drive(GroundPath(Points{{-0.4, -1.8}, {-0.4, 1}, {-0.6, 3}, {-0.5, 5}, {-0.4, 8}}),
                                SpeedProfile({{0.0, 0.8}, {3.0, 0.5}, {6.0, 0.8}}), 1.2);
  const Sway bob{{0.02, 0.015, 0.015}, {0.015, 0.02, 0.01}, 0.8, 4.0, variation.seed(13)};
  const Trajectory views = mounted(walk, 1.6, 0.14, bob);
  scene.T_scene_cam = [views](double time_s) {
    // The neck turns about the vertical, 8 cm behind the cameras.
    const Se3 neck{Eigen::AngleAxisd(head_yaw_rad(time_s), Eigen::Vector3d::UnitY()).toRotationMatrix(), {0, 0, -0.08}};
    return views(time_s) * neck * Se3{Eigen::Matrix3d::Identity(), {0, 0, 0.08}};
  };
  return scene;
}

}  // namespace kinetrace::simulator
