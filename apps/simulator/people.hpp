// Walking people: rigid limbs on joints.
#pragma once

#include <cstdint>

#include "motion.hpp"
#include "scene.hpp"

namespace kinetrace::simulator {

enum class Arms : std::uint8_t { kSwinging, kPushing };

inline constexpr double kPersonHeight_m = 1.75;

/// A person who walks along `path`. The gait follows the distance covered: feet stay where they tread.
[[nodiscard]] Actor walking_person(GroundPath path, SpeedProfile speed, double start_m, std::uint16_t seed,
                                   double height_m = kPersonHeight_m, Arms arms = Arms::kSwinging);

}  // namespace kinetrace::simulator
