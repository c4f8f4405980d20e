// Differences between worlds of the same scene.
#pragma once

#include <cstdint>

#include "world/motion.hpp"
#include "world/scene.hpp"
#include "world/vehicles.hpp"

namespace kinetrace::simulator {

/// World 1 is the scene as designed. Every other world has the same events among other houses, trees and vehicles, on
/// other ground, under another sun, a little slower; every vehicle and person has its own pace, place in the lane,
/// place to park and height. Keys distinguish vehicles and people.
class Variation {
 public:
  /// `variation_strength` in [0, 1]: how far vehicles and people may depart from the design.
  explicit Variation(std::uint32_t world = 1, double variation_strength = 1.0)
      : world_(world), variation_strength_(world == 1 ? 0.0 : variation_strength) {}

  /// Seed of a scene's other random choices.
  [[nodiscard]] std::uint32_t seed(std::uint32_t first) const noexcept;
  /// Of a vehicle or a person.
  [[nodiscard]] std::uint16_t look(std::uint16_t first) const noexcept;
  /// Of a parked vehicle. Trucks stay trucks: they need the room.
  [[nodiscard]] VehicleKind kind(VehicleKind first, std::uint32_t key) const noexcept;
  /// Empty parking spots.
  [[nodiscard]] bool is_empty(std::uint32_t key) const noexcept;
  /// Position of a parked vehicle along the street, instead of `first_m`.
  [[nodiscard]] double place_m(double first_m, std::uint32_t key) const noexcept;
  /// Height of a person.
  [[nodiscard]] double height_m(std::uint32_t key) const noexcept;
  /// Individual pace: up to 7 % slower than designed.
  [[nodiscard]] SpeedProfile paced(SpeedProfile speed, std::uint32_t key) const;
  /// Up to `most_m` to the left or to the right of the path.
  [[nodiscard]] Trajectory aside(Trajectory trajectory, double most_m, std::uint32_t key) const;
  /// Varies the scene as a whole: sun, pace, ground.
  void apply(Scene& scene) const;

 private:
  // Between -1 and 1, for one purpose and key.
  [[nodiscard]] double draw(std::uint32_t purpose, std::uint32_t key) const noexcept;

  std::uint32_t world_;
  double variation_strength_;
};

}  // namespace kinetrace::simulator
