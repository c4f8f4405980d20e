#include "world/people.hpp"

#include <array>
#include <cmath>
#include <numbers>
#include <utility>

#include "world/gait.hpp"

namespace kinetrace::simulator {
namespace {

using Eigen::Vector3d;

constexpr double kShoulderAboveHip_m = 0.5;
constexpr double kHipHalf_m = 0.09;
constexpr double kShoulderHalf_m = 0.205;

// Swing about the z axis (left): positive brings the hanging end forward.
Se3 joint(const Vector3d& at, double swing_rad) {
  return {Eigen::AngleAxisd(-swing_rad, Vector3d::UnitZ()).toRotationMatrix(), at};
}

bool is_left(std::size_t part) {
  return part == kThighL || part == kShinL || part == kFootL || part == kUpperArmL || part == kForearmL;
}

Se3 part_pose(std::size_t part, double cycle, Arms arms) {
  const bool left = is_left(part);
  const double side = left ? 1.0 : -1.0;
  const Leg leg = leg_at(left ? cycle : cycle + 0.5);
  const double hip_m = hip_height_m(cycle);
  Se3 hip = joint({0.0, -hip_m, side * kHipHalf_m}, leg.hip_rad);
  Se3 knee = hip * joint({0.0, kThigh_m, 0.0}, -leg.knee_rad);
  const bool pushing = arms == Arms::kPushing;
  // Arms swing opposite to the legs.
  const double swing = std::cos(2.0 * std::numbers::pi * (left ? cycle : cycle + 0.5));
  Se3 shoulder =
      joint({0.0, -hip_m - kShoulderAboveHip_m, side * kShoulderHalf_m}, pushing ? 0.45 : 0.05 - 0.38 * swing);
  switch (part) {
    case kThighL:
    case kThighR: return hip;
    case kShinL:
    case kShinR: return knee;
    case kFootL:
    case kFootR: return knee * joint({0.0, kShin_m, 0.0}, leg.ankle_rad);
    case kUpperArmL:
    case kUpperArmR: return shoulder;
    case kForearmL:
    case kForearmR: return shoulder * joint({0.0, kUpperArm_m, 0.0}, pushing ? 0.75 : 0.35 - 0.2 * swing);
    default: return {Eigen::Matrix3d::Identity(), {0.0, -hip_m, 0.0}};
  }
}

// On straight legs.
Se3 standing_part_pose(std::size_t part, const Stance& stance) {
  const double hip_m = kThigh_m + kShin_m + kAnkle_m;
  const auto side = static_cast<std::size_t>(is_left(part) ? 0 : 1);
  const double left_m = is_left(part) ? 1.0 : -1.0;
  Se3 hip{Eigen::Matrix3d::Identity(), {0.0, -hip_m, left_m * kHipHalf_m}};
  Se3 trunk = joint({0.0, -hip_m, 0.0}, -stance.lean_rad);
  Se3 shoulder = trunk * joint({0.0, -kShoulderAboveHip_m, left_m * kShoulderHalf_m},
                               stance.shoulders_rad[side] + stance.lean_rad);
  switch (part) {
    case kThighL:
    case kThighR: return hip;
    case kShinL:
    case kShinR: return hip * joint({0.0, kThigh_m, 0.0}, 0.0);
    case kFootL:
    case kFootR: return hip * joint({0.0, kThigh_m + kShin_m, 0.0}, 0.0);
    case kUpperArmL:
    case kUpperArmR: return shoulder;
    case kForearmL:
    case kForearmR: return shoulder * joint({0.0, kUpperArm_m, 0.0}, stance.elbows_rad[side]);
    default: return trunk;
  }
}

// Without any motion.
Actor person(std::uint16_t seed, double scale, const Outfit& outfit) {
  Actor actor;
  actor.class_id = kPedestrianClass;
  actor.rigid = false;
  actor.size_lhw_m = scale * Vector3d(0.8, kPersonHeight_m, 0.6);
  actor.parts = body_parts(seed, outfit);
  for (Mesh& part : actor.parts) {
    part.scale(static_cast<float>(scale));
  }
  return actor;
}

}  // namespace

Actor walking_person(GroundPath path, SpeedProfile speed, double start_m, std::uint16_t seed, double height_m,
                     Arms arms, const Outfit& outfit) {
  // Stride length grows with height.
  const double scale = height_m / kPersonHeight_m;
  Actor actor = person(seed, scale, outfit);
  actor.T_obj_part = [speed, seed, arms, scale](double time_s, std::size_t part) {
    Se3 pose = part_pose(part, speed.distance_m(time_s) / (scale * kStride_m) + 0.37 * seed, arms);
    pose.translation *= scale;
    return pose;
  };
  actor.T_scene_obj = drive(std::move(path), std::move(speed), start_m);
  return actor;
}

Actor standing_person(Trajectory place, const Stance& stance, std::uint16_t seed, double height_m,
                      const Outfit& outfit) {
  const double scale = height_m / kPersonHeight_m;
  Actor actor = person(seed, scale, outfit);
  actor.T_obj_part = [stance, scale](double /*time_s*/, std::size_t part) {
    Se3 pose = standing_part_pose(part, stance);
    pose.translation *= scale;
    return pose;
  };
  actor.T_scene_obj = std::move(place);
  return actor;
}

}  // namespace kinetrace::simulator
