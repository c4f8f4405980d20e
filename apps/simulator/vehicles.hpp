// Road vehicles of several kinds.
#pragma once

#include <cstdint>

#include <Eigen/Core>

#include "mesh.hpp"

namespace kinetrace::simulator {

enum class VehicleKind : std::uint8_t { kHatchback, kSedan, kVan, kTruck };
inline constexpr int kVehicleKinds = 4;

/// The whole vehicle: skin, wheels, mirrors, for a truck its box. Origin under its middle on the ground, x forward, y
/// down, z left. `seed` varies paint and plates.
[[nodiscard]] Mesh vehicle_mesh(VehicleKind kind, std::uint16_t seed);

/// Length, height, width of the box around it.
[[nodiscard]] Eigen::Vector3f vehicle_size_m(VehicleKind kind);

}  // namespace kinetrace::simulator
