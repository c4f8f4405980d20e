// Vehicles of any make: bodies, windows, lamps and paint drawn at random.
#pragma once

#include <memory>
#include <optional>

#include "util/random.hpp"
#include "world/vehicles.hpp"

namespace kinetrace::simulator {

struct RandomVehicle {
  std::shared_ptr<const BodyShape> shape;                ///< The mesh's paint points to it.
  Mesh mesh;                                             ///< As of vehicle_mesh.
  Eigen::Vector3f size_lhw_m = Eigen::Vector3f::Zero();  ///< Without open doors.
  /// Where somebody stands, x and z in the vehicle, who gets in by an open door; if there is one.
  std::optional<Eigen::Vector2f> doorway_m;
};

/// A small car, saloon, estate, coupe, off-roader, people carrier, van, delivery van, bus, pick-up or box truck, with
/// proportions and looks of its own.
[[nodiscard]] RandomVehicle random_vehicle(Random& random);

}  // namespace kinetrace::simulator
