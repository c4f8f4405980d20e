// Walking and standing people: rigid limbs on joints.
#pragma once

#include <array>
#include <cstdint>

#include "world/body.hpp"
#include "world/motion.hpp"
#include "world/scene.hpp"

namespace kinetrace::simulator {

enum class Arms : std::uint8_t { kSwinging, kPushing };

inline constexpr double kPersonHeight_m = 1.75;

/// A person who walks along `path`. The gait follows the distance covered, so that feet do not slip.
[[nodiscard]] Actor walking_person(GroundPath path, SpeedProfile speed, double start_m, std::uint16_t seed,
                                   double height_m = kPersonHeight_m, Arms arms = Arms::kSwinging,
                                   const Outfit& outfit = {});

/// Posture of a standing person: left and right arm, positive forwards, and the trunk.
struct Stance {
  std::array<double, 2> shoulders_rad{};
  std::array<double, 2> elbows_rad{};
  double lean_rad = 0.0;  ///< Of trunk, head and arms; forwards.
};
[[nodiscard]] Actor standing_person(Trajectory place, const Stance& stance, std::uint16_t seed, double height_m,
                                    const Outfit& outfit = {});

}  // namespace kinetrace::simulator
