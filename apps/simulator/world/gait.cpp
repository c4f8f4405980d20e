#include "world/gait.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace kinetrace::simulator {
namespace {

constexpr double kPi = std::numbers::pi;
// Fraction of a cycle in which a foot is on the ground (D. Winter, "Biomechanics and motor control of human movement",
// 1987: 0.6 at a walk; slightly less, as this pelvis does not rotate).
constexpr double kStance = 0.55;
constexpr double kReach_m = 0.5 * kStance * kStride_m;

struct Foot {
  double ahead_m = 0.0;    ///< Of the ankle against the hip.
  double ankle_m = 0.0;    ///< Height of the ankle.
  double pitch_rad = 0.0;  ///< Toes up positive.
};

double eased(double s) {
  const double t = std::clamp(s, 0.0, 1.0);
  return t * t * (3.0 - 2.0 * t);
}

// `u` counts from the moment when the foot touches the ground, up to kStance.
Foot carrying_foot(double u, double toe_up_rad) {
  // At the end the heel rises while the ball of the foot stays: the ankle turns about it.
  constexpr double kHeelRise_rad = 0.5;
  constexpr double kBall_m = 0.13;
  const double rise_rad = kHeelRise_rad * eased((u / kStance - 0.65) / 0.35);
  const double land_rad = toe_up_rad * (1.0 - eased(u / 0.08));
  const double forward_m = kBall_m * (1.0 - std::cos(rise_rad)) + kAnkle_m * std::sin(rise_rad);
  const double up_m = kBall_m * std::sin(rise_rad) - kAnkle_m * (1.0 - std::cos(rise_rad));
  return {kReach_m - kStride_m * u + forward_m, kAnkle_m + up_m, land_rad - rise_rad};
}

Foot foot_at(double cycle) {
  constexpr double kToeUp_rad = 0.25;
  constexpr double kLift_m = 0.05;
  const double u = cycle - std::floor(cycle);
  if (u < kStance) {
    return carrying_foot(u, kToeUp_rad);
  }
  const double s = (u - kStance) / (1.0 - kStance);
  const double t = eased(s);
  const Foot off = carrying_foot(kStance, kToeUp_rad);
  return {off.ahead_m + (kReach_m - off.ahead_m) * t,
          off.ankle_m + (kAnkle_m - off.ankle_m) * t + kLift_m * std::sin(kPi * s),
          off.pitch_rad + (kToeUp_rad - off.pitch_rad) * t};
}

}  // namespace

double hip_height_m(double cycle) {
  // Lowest when a foot touches the ground, highest in between.
  return 0.89 - 0.02 * std::cos(4.0 * kPi * (cycle - 0.02));
}

Leg leg_at(double cycle) {
  const Foot foot = foot_at(cycle);
  const double down_m = hip_height_m(cycle) - foot.ankle_m;
  // The leg is never fully stretched.
  const double length_m = std::min(std::hypot(foot.ahead_m, down_m), 0.999 * (kThigh_m + kShin_m));
  const double at_hip = (kThigh_m * kThigh_m + length_m * length_m - kShin_m * kShin_m) / (2.0 * kThigh_m * length_m);
  const double at_knee = (kThigh_m * kThigh_m + kShin_m * kShin_m - length_m * length_m) / (2.0 * kThigh_m * kShin_m);
  Leg leg;
  leg.hip_rad = std::atan2(foot.ahead_m, down_m) + std::acos(std::clamp(at_hip, -1.0, 1.0));
  leg.knee_rad = kPi - std::acos(std::clamp(at_knee, -1.0, 1.0));
  leg.ankle_rad = foot.pitch_rad - leg.hip_rad + leg.knee_rad;
  return leg;
}

}  // namespace kinetrace::simulator
