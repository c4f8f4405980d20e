#include "world/people.hpp"

#include <array>
#include <cmath>
#include <numbers>
#include <utility>

#include "world/gait.hpp"

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
  kFootL,
  kFootR,
  kUpperArmL,
  kUpperArmR,
  kForearmL,
  kForearmR,
  kPartCount
};

constexpr double kShoulderAboveHip_m = 0.5;
constexpr double kUpperArm_m = 0.29;
constexpr double kHipHalf_m = 0.09;
constexpr double kShoulderHalf_m = 0.205;

// Limbs hang from their joint at the origin, y down.
Mesh limb(float length, float radius, float end_radius, const Paint& paint) {
  Mesh mesh;
  mesh.add_cylinder({0.F, 0.F, 0.F}, {0.F, length, 0.F}, radius, end_radius, 12, paint);
  mesh.add_ellipsoid({0.F, 0.F, 0.F}, Vector3f::Constant(radius), 6, paint);
  mesh.add_ellipsoid({0.F, length, 0.F}, Vector3f::Constant(end_radius), 6, paint);
  return mesh;
}

// An upright ellipse of the trunk's skin, `above_m` above the hip.
struct Girth {
  float above_m;
  float deep_m;  ///< Half axes.
  float wide_m;
};

template <std::size_t N>
void add_trunk(Mesh& mesh, const std::array<Girth, N>& girths, const Paint& paint) {
  constexpr int kPoints = 16;
  std::vector<std::vector<Vector3f>> rings;
  for (const Girth& girth : girths) {
    std::vector<Vector3f>& ring = rings.emplace_back();
    for (int i = 0; i < kPoints; ++i) {
      const float angle = 2.F * std::numbers::pi_v<float> * static_cast<float>(i) / kPoints;
      ring.emplace_back(girth.deep_m * std::cos(angle), -girth.above_m, girth.wide_m * std::sin(angle));
    }
  }
  mesh.add_loft(rings, paint);
}

// Relative to the middle of the hip.
Mesh torso(const Paint& shirt, const Paint& trousers) {
  Mesh mesh;
  add_trunk(mesh,
            std::array<Girth, 8>{{{0.06F, 0.115F, 0.165F},
                                  {0.16F, 0.105F, 0.145F},
                                  {0.28F, 0.11F, 0.16F},
                                  {0.4F, 0.12F, 0.185F},
                                  {0.48F, 0.11F, 0.195F},
                                  {0.54F, 0.09F, 0.16F},
                                  {0.575F, 0.065F, 0.08F},
                                  {0.585F, 0.03F, 0.03F}}},
            shirt);
  add_trunk(mesh,
            std::array<Girth, 4>{
                {{-0.09F, 0.07F, 0.09F}, {-0.03F, 0.11F, 0.165F}, {0.05F, 0.118F, 0.17F}, {0.1F, 0.108F, 0.15F}}},
            trousers);
  for (const float side : {1.F, -1.F}) {
    mesh.add_ellipsoid({0.F, -0.49F, side * 0.185F}, {0.07F, 0.065F, 0.065F}, 8, shirt);
  }
  return mesh;
}

Mesh head(const Paint& skin, const Paint& hair) {
  Mesh mesh;
  mesh.add_ellipsoid({0.02F, -0.72F, 0.F}, {0.095F, 0.125F, 0.08F}, 10, skin);
  mesh.add_ellipsoid({-0.012F, -0.75F, 0.F}, {0.098F, 0.11F, 0.088F}, 10, hair);
  mesh.add_ellipsoid({0.112F, -0.71F, 0.F}, {0.018F, 0.024F, 0.014F}, 6, skin);
  mesh.add_cylinder({-0.005F, -0.62F, 0.F}, {-0.01F, -0.53F, 0.F}, 0.05F, 0.06F, 12, skin);
  return mesh;
}

std::vector<Mesh> body_parts(std::uint16_t seed) {
  const auto variant = [seed](int offset) { return static_cast<std::uint16_t>(seed + offset); };
  const Paint shirt{Material::kCloth, seed};
  const Paint trousers{Material::kTrousers, variant(100)};
  const Paint skin{Material::kSkin, seed};
  std::vector<Mesh> parts(kPartCount);
  parts[kTorso] = torso(shirt, trousers);
  parts[kHead] = head(skin, {Material::kHair, variant(200)});
  for (const Part thigh : {kThighL, kThighR}) {
    parts[thigh] = limb(static_cast<float>(kThigh_m), 0.082F, 0.06F, trousers);
  }
  for (const Part shin : {kShinL, kShinR}) {
    parts[shin] = limb(static_cast<float>(kShin_m), 0.06F, 0.047F, trousers);
  }
  for (const Part foot : {kFootL, kFootR}) {
    // The sole is as far below the ankle as the gait has it.
    parts[foot].add_ellipsoid({0.055F, 0.04F, 0.F}, {0.135F, static_cast<float>(kAnkle_m) - 0.04F, 0.046F}, 8,
                              {Material::kShoe, seed});
    parts[foot].add_ellipsoid({-0.01F, 0.015F, 0.F}, {0.06F, 0.055F, 0.042F}, 6, {Material::kShoe, seed});
  }
  for (const Part arm : {kUpperArmL, kUpperArmR}) {
    parts[arm] = limb(static_cast<float>(kUpperArm_m), 0.052F, 0.043F, shirt);
  }
  for (const Part forearm : {kForearmL, kForearmR}) {
    parts[forearm] = limb(0.24F, 0.041F, 0.032F, skin);
    parts[forearm].add_ellipsoid({0.01F, 0.3F, 0.F}, {0.04F, 0.075F, 0.02F}, 6, skin);
  }
  return parts;
}

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
  const Se3 hip = joint({0.0, -hip_m, side * kHipHalf_m}, leg.hip_rad);
  const Se3 knee = hip * joint({0.0, kThigh_m, 0.0}, -leg.knee_rad);
  const bool pushing = arms == Arms::kPushing;
  // Arms swing against the legs.
  const double swing = std::cos(2.0 * std::numbers::pi * (left ? cycle : cycle + 0.5));
  const Se3 shoulder =
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
  const Se3 hip{Eigen::Matrix3d::Identity(), {0.0, -hip_m, left_m * kHipHalf_m}};
  const Se3 shoulder = joint({0.0, -hip_m - kShoulderAboveHip_m, left_m * kShoulderHalf_m}, stance.shoulders_rad[side]);
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
    default: return {Eigen::Matrix3d::Identity(), {0.0, -hip_m, 0.0}};
  }
}

// Without any motion.
Actor person(std::uint16_t seed, double scale) {
  Actor actor;
  actor.class_id = kPedestrianClass;
  actor.rigid = false;
  actor.size_lhw_m = scale * Vector3d(0.8, kPersonHeight_m, 0.6);
  actor.parts = body_parts(seed);
  for (Mesh& part : actor.parts) {
    part.scale(static_cast<float>(scale));
  }
  return actor;
}

}  // namespace

Actor walking_person(GroundPath path, SpeedProfile speed, double start_m, std::uint16_t seed, double height_m,
                     Arms arms) {
  // The taller, the longer the stride.
  const double scale = height_m / kPersonHeight_m;
  Actor actor = person(seed, scale);
  actor.T_obj_part = [speed, seed, arms, scale](double time_s, std::size_t part) {
    Se3 pose = part_pose(part, speed.distance_m(time_s) / (scale * kStride_m) + 0.37 * seed, arms);
    pose.translation *= scale;
    return pose;
  };
  actor.T_scene_obj = drive(std::move(path), std::move(speed), start_m);
  return actor;
}

Actor standing_person(Trajectory place, const Stance& stance, std::uint16_t seed, double height_m) {
  const double scale = height_m / kPersonHeight_m;
  Actor actor = person(seed, scale);
  actor.T_obj_part = [stance, scale](double /*time_s*/, std::size_t part) {
    Se3 pose = standing_part_pose(part, stance);
    pose.translation *= scale;
    return pose;
  };
  actor.T_scene_obj = std::move(place);
  return actor;
}

}  // namespace kinetrace::simulator
