// Common parts of the street scenes.
#pragma once

#include <cstdint>

#include "scenes/variation.hpp"
#include "world/motion.hpp"
#include "world/scene.hpp"
#include "world/vehicles.hpp"

namespace kinetrace::simulator {

/// Headings on a street along z.
inline constexpr double kAlongZ_rad = -1.5707963267948966;   ///< Towards +z.
inline constexpr double kAgainstZ_rad = 1.5707963267948966;  ///< Towards -z.

/// Height of the sidewalks.
inline constexpr float kCurb_m = 0.12F;

/// A street along z with lanes, parking strips, sidewalks, houses, trees, hedges, lamps; a cross street at
/// `crossing_z_m`.
struct StreetPlan {
  float z0_m = -30.F;
  float z1_m = 170.F;
  float half_road_m = 6.9F;  ///< Four lanes.
  float parking_m = 2.2F;    ///< Width of the strips beside them.
  float sidewalk_m = 3.F;
  float crossing_z_m = 62.F;
  float half_crossing_m = 4.5F;
  std::uint32_t seed = 1;
};
[[nodiscard]] Mesh street_world(const StreetPlan& plan);

/// The rig of a car: 1242 x 375 pixels, 54 cm baseline.
[[nodiscard]] StereoGeometry car_rig();

[[nodiscard]] Actor vehicle(VehicleKind kind, std::uint16_t seed, Trajectory trajectory);
/// A vehicle in traffic; `seed` also is the key of its variation.
[[nodiscard]] Actor driven_vehicle(const Variation& variation, VehicleKind kind, std::uint16_t seed, GroundPath path,
                                   SpeedProfile speed, double start_m);
/// A place to park at the curb of the right (`side` 1) or the left (-1) parking strip, in the direction of the traffic
/// there, rotated by `askew_rad`.
struct ParkingSpot {
  VehicleKind kind = VehicleKind::kHatchback;
  double side = 1.0;
  double z_m = 0.0;
  double askew_rad = 0.0;
};
/// Adds the vehicle parked there, if any; `seed` also is the key of its variation.
void add_parked(Scene& scene, const Variation& variation, const ParkingSpot& spot, std::uint16_t seed);
/// A person walking along a sidewalk.
[[nodiscard]] Actor passer_by(const Variation& variation, GroundPath path, SpeedProfile speed, double start_m,
                              std::uint16_t seed);

}  // namespace kinetrace::simulator
