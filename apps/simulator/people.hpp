// Walking people: rigid limbs on joints.
#pragma once

#include <cstdint>

#include "motion.hpp"
#include "scene.hpp"

namespace kinetrace::simulator {

/// A person of 1.7 m who walks along `path`; the gait follows the speed.
[[nodiscard]] Actor walking_person(GroundPath path, SpeedProfile speed, double start_m, std::uint16_t seed);

/// A person who stands, shifting weight a little. Truth calls it non-rigid too.
[[nodiscard]] Actor standing_person(double x_m, double z_m, double heading_rad, std::uint16_t seed);

}  // namespace kinetrace::simulator
