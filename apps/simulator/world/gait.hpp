// Walking motion of legs.
#pragma once

namespace kinetrace::simulator {

inline constexpr double kThigh_m = 0.43;
inline constexpr double kShin_m = 0.42;
inline constexpr double kAnkle_m = 0.08;  ///< Height of the ankle over the sole.
inline constexpr double kStride_m = 1.3;  ///< Covered in one cycle: two steps.

/// Angles of a leg's joints, forward positive: the thigh against the vertical, the bend of the knee, and the foot
/// against the shin.
struct Leg {
  double hip_rad = 0.0;
  double knee_rad = 0.0;
  double ankle_rad = 0.0;
};

/// Height of the hip joints over the ground; `cycle` counts strides.
[[nodiscard]] double hip_height_m(double cycle);

/// The leg whose foot touches the ground when `cycle` is a whole number. A standing foot does not slip: it moves
/// backwards relative to the body by the distance that the body covers.
[[nodiscard]] Leg leg_at(double cycle);

}  // namespace kinetrace::simulator
