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
  /// Position, x and z in the vehicle, of a person getting in by the open door; none if doors are closed.
  std::optional<Eigen::Vector2f> doorway_m;
};

/// A small car, saloon, estate, coupe, off-roader, people carrier, van, delivery van, bus, pick-up or box truck, with
/// random proportions and looks.
[[nodiscard]] RandomVehicle random_vehicle(Random& random);

}  // namespace kinetrace::simulator
