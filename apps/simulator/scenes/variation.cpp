#include "scenes/variation.hpp"

#include <array>
#include <utility>

#include <Eigen/Geometry>

#include "util/random.hpp"
#include "world/people.hpp"

namespace kinetrace::simulator {
namespace {

// One factor for everything, so that it causes no new collisions.
void set_pace(Scene& scene, double pace) {
  const auto paced = [pace](Trajectory trajectory) -> Trajectory {
    return [pace, trajectory = std::move(trajectory)](double time_s) { return trajectory(pace * time_s); };
  };
  scene.T_scene_cam = paced(std::move(scene.T_scene_cam));
  for (Actor& actor : scene.actors) {
    actor.T_scene_obj = paced(std::move(actor.T_scene_obj));
    if (actor.T_obj_part) {
      actor.T_obj_part = [pace, pose = std::move(actor.T_obj_part)](double time_s, std::size_t part) {
        return pose(pace * time_s, part);
      };
    }
  }
}

}  // namespace

std::uint32_t Variation::seed(std::uint32_t first) const noexcept {
  return world_ == 1 ? first : hash_of(world_, first, 1);
}

std::uint16_t Variation::look(std::uint16_t first) const noexcept {
  return world_ == 1 ? first : static_cast<std::uint16_t>(hash_of(world_, first, 2));
}

VehicleKind Variation::kind(VehicleKind first, std::uint32_t key) const noexcept {
  if (world_ == 1 || first == VehicleKind::kTruck) {
    return first;
  }
  constexpr std::array<VehicleKind, 3> kSmall{VehicleKind::kHatchback, VehicleKind::kSedan, VehicleKind::kVan};
  return kSmall[hash_of(world_, key, 3) % kSmall.size()];
}

double Variation::draw(std::uint32_t purpose, std::uint32_t key) const noexcept {
  return 2.0 * static_cast<double>(unit_float(hash_of(world_, key, purpose))) - 1.0;
}

bool Variation::is_empty(std::uint32_t key) const noexcept {
  constexpr double kEmpty = 0.15;
  return variation_strength_ > 0.0 && draw(5, key) < 2.0 * kEmpty - 1.0;
}

double Variation::place_m(double first_m, std::uint32_t key) const noexcept {
  constexpr double kMax_m = 0.8;
  return first_m + variation_strength_ * kMax_m * draw(6, key);
}

double Variation::height_m(std::uint32_t key) const noexcept {
  constexpr double kMax_m = 0.16;
  return kPersonHeight_m + variation_strength_ * kMax_m * draw(7, key);
}

SpeedProfile Variation::paced(SpeedProfile speed, std::uint32_t key) const {
  constexpr double kMax = 0.07;
  return speed.scaled(1.0 - 0.5 * kMax * variation_strength_ * (1.0 + draw(8, key)));
}

Trajectory Variation::aside(Trajectory trajectory, double most_m, std::uint32_t key) const {
  const double left_m = variation_strength_ * most_m * draw(9, key);
  return [trajectory = std::move(trajectory), left_m](double time_s) {
    Se3 pose = trajectory(time_s);
    pose.translation += left_m * pose.rotation.col(2);
    return pose;
  };
}

void Variation::apply(Scene& scene) const {
  if (world_ == 1) {
    return;
  }
  Random random(world_, 4);
  const auto turn = static_cast<float>(random.uniform(-0.7, 0.7));
  scene.light.to_sun = Eigen::AngleAxisf(turn, Eigen::Vector3f::UnitY()) * scene.light.to_sun;
  scene.light.to_sun.y() *= static_cast<float>(random.uniform(0.8, 1.3));
  // Whole metres keep textures aligned with the edges of slabs.
  const auto metres = [&] { return static_cast<float>(random.index(200) - 100); };
  const float x = metres();
  scene.texture_origin_m = {x, 0.F, metres()};
  set_pace(scene, random.uniform(0.92, 0.99));
}

}  // namespace kinetrace::simulator
