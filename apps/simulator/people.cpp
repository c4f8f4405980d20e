#include "people.hpp"

#include <array>
#include <cmath>
#include <numbers>
#include <utility>

namespace kinetrace::simulator {
namespace {

using Eigen::Vector3d;
using Eigen::Vector3f;

enum Part : std::size_t {
  kTorso,
  kHead,
  kThighL,
  kThighR,
  kShinL,
  kShinR,
  kUpperArmL,
  kUpperArmR,
  kForearmL,
  kForearmR,
  kPartCount
};

constexpr double kHip_m = 0.9;
constexpr double kThigh_m = 0.43;
constexpr double kShoulder_m = 1.4;
constexpr double kUpperArm_m = 0.29;
constexpr double kHipHalf_m = 0.1;
constexpr double kShoulderHalf_m = 0.22;
constexpr double kStride_m = 1.4;  ///< Two steps.

// Limbs hang from their joint at the origin, y down.
Mesh limb(float length, float radius, float end_radius, const Paint& paint) {
  Mesh mesh;
  mesh.add_cylinder({0.F, 0.F, 0.F}, {0.F, length, 0.F}, radius, end_radius, 12, paint);
  mesh.add_ellipsoid({0.F, 0.F, 0.F}, Vector3f::Constant(radius), 6, paint);
  mesh.add_ellipsoid({0.F, length, 0.F}, Vector3f::Constant(end_radius), 6, paint);
  return mesh;
}

std::vector<Mesh> body_parts(std::uint16_t seed) {
  const Paint shirt{Material::kCloth, seed};
  const Paint trousers{Material::kCloth, static_cast<std::uint16_t>(seed + 100)};
  const Paint skin{Material::kSkin, seed};
  std::vector<Mesh> parts(kPartCount);
  parts[kTorso].add_ellipsoid({0.F, -1.2F, 0.F}, {0.14F, 0.34F, 0.21F}, 12, shirt);
  parts[kTorso].add_ellipsoid({0.F, -0.93F, 0.F}, {0.13F, 0.14F, 0.17F}, 10, trousers);
  parts[kHead].add_ellipsoid({0.02F, -1.6F, 0.F}, {0.1F, 0.12F, 0.085F}, 10, skin);
  parts[kHead].add_ellipsoid({-0.015F, -1.63F, 0.F}, {0.1F, 0.11F, 0.093F}, 10,
                             {Material::kCloth, static_cast<std::uint16_t>(seed + 200)});
  parts[kHead].add_cylinder({0.F, -1.53F, 0.F}, {0.F, -1.4F, 0.F}, 0.055F, 0.06F, 10, skin);
  for (const Part thigh : {kThighL, kThighR}) {
    parts[thigh] = limb(0.43F, 0.085F, 0.065F, trousers);
  }
  for (const Part shin : {kShinL, kShinR}) {
    parts[shin] = limb(0.38F, 0.062F, 0.045F, trousers);
    parts[shin].add_ellipsoid({0.07F, 0.43F, 0.F}, {0.13F, 0.045F, 0.05F}, 8, {Material::kShoe});
  }
  for (const Part arm : {kUpperArmL, kUpperArmR}) {
    parts[arm] = limb(0.29F, 0.055F, 0.045F, shirt);
  }
  for (const Part forearm : {kForearmL, kForearmR}) {
    parts[forearm] = limb(0.25F, 0.043F, 0.035F, skin);
  }
  return parts;
}

// Swing about the z axis (left): positive brings the hanging end forward.
Se3 joint(const Vector3d& at, double swing_rad) {
  return {Eigen::AngleAxisd(-swing_rad, Vector3d::UnitZ()).toRotationMatrix(), at};
}

// Hip, knee, shoulder and elbow follow sines of the gait's phase (after the mean curves of D. Winter, "Biomechanics and
// motor control of human movement", 1987, much simplified).
Se3 part_pose(std::size_t part, double phase, double swing) {
  const bool left = part == kThighL || part == kShinL || part == kUpperArmL || part == kForearmL;
  const double side = left ? 1.0 : -1.0;
  const double leg_phase = left ? phase : phase + std::numbers::pi;
  const double bob_m = 0.02 * swing * std::cos(2.0 * phase);
  const Vector3d hip(0.0, -kHip_m + bob_m, side * kHipHalf_m);
  const Vector3d shoulder(0.0, -kShoulder_m + bob_m, side * kShoulderHalf_m);
  const Se3 thigh = joint(hip, swing * 0.42 * std::sin(leg_phase));
  const Se3 upper_arm = joint(shoulder, -swing * 0.38 * std::sin(leg_phase));
  switch (part) {
    case kThighL:
    case kThighR: return thigh;
    case kShinL:
    case kShinR: return thigh * joint({0.0, kThigh_m, 0.0}, -swing * 0.45 * (1.0 + std::cos(leg_phase)) - 0.05);
    case kUpperArmL:
    case kUpperArmR: return upper_arm;
    case kForearmL:
    case kForearmR: return upper_arm * joint({0.0, kUpperArm_m, 0.0}, 0.25 + swing * 0.2 * (1.0 - std::sin(leg_phase)));
    default: return {Eigen::Matrix3d::Identity(), {0.0, bob_m, 0.0}};
  }
}

Actor person(std::uint16_t seed) {
  Actor actor;
  actor.class_id = kPedestrianClass;
  actor.rigid = false;
  actor.size_lhw_m = {0.6, 1.75, 0.6};
  actor.parts = body_parts(seed);
  return actor;
}

}  // namespace

Actor walking_person(GroundPath path, SpeedProfile speed, double start_m, std::uint16_t seed) {
  Actor actor = person(seed);
  actor.T_obj_part = [speed, seed](double time_s, std::size_t part) {
    const double phase = 2.0 * std::numbers::pi * speed.distance_m(time_s) / kStride_m + seed;
    return part_pose(part, phase, 1.0);
  };
  actor.T_scene_obj = drive(std::move(path), std::move(speed), start_m);
  return actor;
}

Actor standing_person(double x_m, double z_m, double heading_rad, std::uint16_t seed) {
  Actor actor = person(seed);
  actor.T_obj_part = [seed](double time_s, std::size_t part) {
    return part_pose(part, 0.4 * std::sin(0.9 * time_s + seed), 0.25);
  };
  actor.T_scene_obj = parked(x_m, z_m, heading_rad);
  return actor;
}

}  // namespace kinetrace::simulator
