// What differs between two worlds of the same scene.
#pragma once

#include <cstdint>

#include "world/motion.hpp"
#include "world/scene.hpp"
#include "world/vehicles.hpp"

namespace kinetrace::simulator {

/// World 1 is the one that a scene has been laid out for. In every other world the same things happen among other
/// houses, trees and vehicles, on other ground, under another sun, a little slower; and everybody has a pace, a place
/// in the lane, a place to park and a height of their own. Keys tell one from the other.
class Variation {
 public:
  /// `liberty` in [0, 1]: how far vehicles and people may depart from what has been laid out.
  explicit Variation(std::uint32_t world = 1, double liberty = 1.0)
      : world_(world), liberty_(world == 1 ? 0.0 : liberty) {}

  /// For whatever a scene draws at random.
  [[nodiscard]] std::uint32_t seed(std::uint32_t first) const noexcept;
  /// Of a vehicle or a person.
  [[nodiscard]] std::uint16_t look(std::uint16_t first) const noexcept;
  /// Of a parked vehicle. Trucks stay trucks: they need the room.
  [[nodiscard]] VehicleKind kind(VehicleKind first, std::uint32_t key) const noexcept;
  /// Nobody has parked there.
  [[nodiscard]] bool is_empty(std::uint32_t key) const noexcept;
  /// Where somebody has parked along the street, instead of at `first_m`.
  [[nodiscard]] double place_m(double first_m, std::uint32_t key) const noexcept;
  /// Height of a person.
  [[nodiscard]] double height_m(std::uint32_t key) const noexcept;
  /// Somebody's own pace: up to 7 % slower than laid out.
  [[nodiscard]] SpeedProfile paced(SpeedProfile speed, std::uint32_t key) const;
  /// Up to `most_m` to the left or to the right of the path.
  [[nodiscard]] Trajectory aside(Trajectory trajectory, double most_m, std::uint32_t key) const;
  /// What concerns the scene as a whole: sun, pace, ground.
  void apply(Scene& scene) const;

 private:
  // Between -1 and 1, for one purpose and key.
  [[nodiscard]] double draw(std::uint32_t purpose, std::uint32_t key) const noexcept;

  std::uint32_t world_;
  double liberty_;
};

}  // namespace kinetrace::simulator
