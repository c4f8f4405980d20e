// A street of scene `varied` during construction, and the surroundings of its vehicles and people.
#pragma once

#include <algorithm>
#include <cmath>
#include <vector>

#include "util/random.hpp"
#include "world/scene.hpp"
#include "world/scenery.hpp"

namespace kinetrace::simulator {

// Occupied places.
class Places {
 public:
  [[nodiscard]] bool is_free(const GroundArea& area) const {
    return std::none_of(taken_.begin(), taken_.end(), [&](const GroundArea& other) {
      return area.x0 < other.x1 && other.x0 < area.x1 && area.z0 < other.z1 && other.z0 < area.z1;
    });
  }
  void take(const GroundArea& area) { taken_.push_back(area); }
  [[nodiscard]] bool take_if_free(const GroundArea& area) {
    const bool free = is_free(area);
    if (free) {
      take(area);
    }
    return free;
  }

 private:
  std::vector<GroundArea> taken_;
};

inline GroundArea around(double x_m, double z_m, double half_x_m, double half_z_m) {
  return {static_cast<float>(x_m - half_x_m), static_cast<float>(x_m + half_x_m), static_cast<float>(z_m - half_z_m),
          static_cast<float>(z_m + half_z_m)};
}

inline float uniform(Random& random, double low, double high) {
  return static_cast<float>(random.uniform(low, high));
}

inline std::uint16_t seed_of(Random& random) {
  return static_cast<std::uint16_t>(random.bits());
}

// A street along z during construction.
struct Site {
  // Range of vehicles and people, within the cameras' view.
  static constexpr double kBegin_m = -14.0;
  static constexpr double kEnd_m = 72.0;
  // Range of houses and trees.
  static constexpr float kFarBegin_m = -70.F;
  static constexpr float kFarEnd_m = 150.F;

  explicit Site(std::uint32_t seed) : random(seed, 61) {}

  Scene scene;
  Random random;
  Places ground;   // Of anything that stands.
  Places heights;  // Only of things that no tree's crown may hang over.
  double half_road_m = 0.0;
  double edge_m = 0.0;  // Where the sidewalks begin, beyond the parking strips.
  double walk_m = 0.0;
  double curb_m = 0.0;
  std::size_t max_vehicles = 0;           // Of those along the street; people need room, too.
  std::vector<Se3> views;                 // Of the camera, one after the other.
  std::vector<Eigen::Vector2d> doorways;  // Beside open doors: x and z.

  [[nodiscard]] double side() { return random.chance(0.5) ? 1.0 : -1.0; }
  [[nodiscard]] double height_m(double x_m) const { return std::abs(x_m) > edge_m ? curb_m : 0.0; }
  [[nodiscard]] bool has_room() const { return scene.actors.size() < static_cast<std::size_t>(kMaxObjects); }
};

/// Ground and its marks, from the road to the yards behind the sidewalks.
void add_surfaces(Site& site);

/// Things of no class on and beside the street.
void add_clutter(Site& site);

/// Houses, fences, hedges and trees on one side, -1 or 1.
void add_roadside(Site& site, float side);

}  // namespace kinetrace::simulator
