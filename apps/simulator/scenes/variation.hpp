// What differs between two worlds of the same scene.
#pragma once

#include <cstdint>

#include "scene.hpp"
#include "vehicles.hpp"

namespace kinetrace::simulator {

/// World 1 is the one that a scene has been laid out for. In every other world the same things happen among other
/// houses, trees and vehicles, on other ground, under another sun, quicker or slower.
class Variation {
 public:
  explicit Variation(std::uint32_t world = 1) : world_(world) {}

  /// For whatever a scene draws at random.
  [[nodiscard]] std::uint32_t seed(std::uint32_t first) const noexcept;
  /// Of a vehicle or a person.
  [[nodiscard]] std::uint16_t look(std::uint16_t first) const noexcept;
  /// Of a parked vehicle; `key` tells it from others. Trucks stay trucks: they need the room.
  [[nodiscard]] VehicleKind kind(VehicleKind first, std::uint32_t key) const noexcept;
  /// What concerns the scene as a whole: sun, pace, ground.
  void apply(Scene& scene) const;

 private:
  std::uint32_t world_;
};

}  // namespace kinetrace::simulator
