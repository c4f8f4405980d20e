// Road vehicles of several kinds.
#pragma once

#include <cstdint>
#include <span>

#include <Eigen/Core>

#include "world/mesh.hpp"

namespace kinetrace::simulator {

enum class VehicleKind : std::uint8_t { kHatchback, kSedan, kVan, kTruck, kBus };
inline constexpr int kVehicleKinds = 5;

/// A point of a body's outline seen from the side.
struct OutlinePoint {
  float x;       ///< From the rear (-0.5) to the front (0.5) of the length.
  float height;  ///< Relative to the vehicle's height.
};

/// Parameters of a vehicle. A truck's shape is that of the cab alone, at the front.
struct VehicleDesign {
  BodyShape shape;
  std::span<const OutlinePoint> outline;  ///< From the rear to the front.
  float box_length_m = 0.F;               ///< Of a truck's box behind the cab; 0: no truck.
  float box_height_m = 0.F;
  float box_floor_m = 0.75F;
  Material box = Material::kTruckBox;
  float box_tone = 1.F;
};

/// The whole vehicle: skin, wheels, mirrors, for a truck its box. Origin under its middle on the ground, x forward, y
/// down, z left. `seed` varies paint and plates.
[[nodiscard]] Mesh vehicle_mesh(VehicleKind kind, std::uint16_t seed);

/// A vehicle of any design. The shape of `design` must outlive the mesh.
[[nodiscard]] Mesh vehicle_mesh(const VehicleDesign& design, std::uint16_t seed, std::uint16_t rim_seed = 0);

/// Length, height, width of the box around it.
[[nodiscard]] Eigen::Vector3f vehicle_size_m(VehicleKind kind);
[[nodiscard]] Eigen::Vector3f vehicle_size_m(const VehicleDesign& design);

}  // namespace kinetrace::simulator
