#include "world/body.hpp"

#include <array>
#include <cmath>
#include <numbers>

#include "world/gait.hpp"

namespace kinetrace::simulator {
namespace {

using Eigen::Vector3f;

// A limb with its joint at the origin.
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
void add_trunk(Mesh& mesh, const std::array<Girth, N>& girths, float factor, const Paint& paint) {
  constexpr int kPoints = 16;
  std::vector<std::vector<Vector3f>> rings;
  for (const Girth& girth : girths) {
    std::vector<Vector3f>& ring = rings.emplace_back();
    for (int i = 0; i < kPoints; ++i) {
      const float angle = 2.F * std::numbers::pi_v<float> * static_cast<float>(i) / kPoints;
      ring.emplace_back(factor * girth.deep_m * std::cos(angle), -girth.above_m,
                        factor * girth.wide_m * std::sin(angle));
    }
  }
  mesh.add_loft(rings, paint);
}

// Materials of the parts.
struct Cloth {
  Paint upper;
  Paint lower;
  Paint skin;
  Paint hair;
  Paint shoe;

  Cloth(std::uint16_t seed, const Outfit& outfit)
      : upper{outfit.plain ? Material::kTrousers : Material::kCloth, seed, nullptr, outfit.upper_tone},
        lower{Material::kTrousers, static_cast<std::uint16_t>(seed + 100), nullptr, outfit.lower_tone},
        skin{Material::kSkin, seed},
        hair{Material::kHair, static_cast<std::uint16_t>(seed + 200), nullptr, outfit.hair_tone},
        shoe{Material::kShoe, seed} {}
};

// A skirt, or the lower part of a dress or a coat: wide enough for the thighs.
void add_skirt(Mesh& mesh, const Outfit& outfit, const Paint& paint) {
  const float low_m = outfit.skirt_m;
  add_trunk(mesh,
            std::array<Girth, 4>{{{-low_m, 0.17F + 0.1F * low_m, 0.2F + 0.1F * low_m},
                                  {-0.5F * low_m, 0.155F, 0.195F},
                                  {0.F, 0.128F, 0.18F},
                                  {0.14F, 0.109F, 0.15F}}},
            outfit.girth, paint);
}

void add_luggage(Mesh& mesh, const Outfit& outfit, const Paint& paint) {
  switch (outfit.luggage) {
    case Outfit::Luggage::kNone: return;
    case Outfit::Luggage::kBackpack:
      mesh.add_ellipsoid({-0.11F - 0.1F * outfit.girth, -0.3F, 0.F}, {0.12F, 0.24F, 0.16F}, 8, paint);
      return;
    case Outfit::Luggage::kShoulderBag:
      mesh.add_box({-0.02F, 0.02F, 0.1F + 0.16F * outfit.girth}, {0.3F, 0.26F, 0.11F}, paint);
      return;
  }
}

Mesh torso(const Outfit& outfit, const Cloth& cloth) {
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
            outfit.girth, cloth.upper);
  add_trunk(mesh,
            std::array<Girth, 4>{
                {{-0.09F, 0.07F, 0.09F}, {-0.03F, 0.11F, 0.165F}, {0.05F, 0.118F, 0.17F}, {0.1F, 0.108F, 0.15F}}},
            outfit.girth, cloth.lower);
  for (const float side : {1.F, -1.F}) {
    mesh.add_ellipsoid({0.F, -0.49F, side * 0.185F}, {0.07F, 0.065F, 0.065F}, 8, cloth.upper);
  }
  if (outfit.skirt_m > 0.F) {
    add_skirt(mesh, outfit, outfit.is_dress ? cloth.upper : cloth.lower);
  }
  add_luggage(mesh, outfit, cloth.hair);
  return mesh;
}

Mesh head(const Outfit& outfit, const Cloth& cloth) {
  Mesh mesh;
  mesh.add_ellipsoid({0.02F, -0.72F, 0.F}, {0.095F, 0.125F, 0.08F}, 10, cloth.skin);
  mesh.add_ellipsoid({-0.012F, -0.75F, 0.F}, {0.098F, 0.11F, 0.088F}, 10, cloth.hair);
  mesh.add_ellipsoid({0.112F, -0.71F, 0.F}, {0.018F, 0.024F, 0.014F}, 6, cloth.skin);
  mesh.add_cylinder({-0.005F, -0.62F, 0.F}, {-0.01F, -0.53F, 0.F}, 0.05F, 0.06F, 12, cloth.skin);
  switch (outfit.head) {
    case Outfit::Head::kShortHair: break;
    case Outfit::Head::kLongHair: mesh.add_ellipsoid({-0.06F, -0.62F, 0.F}, {0.065F, 0.2F, 0.1F}, 8, cloth.hair); break;
    case Outfit::Head::kCap:
      mesh.add_ellipsoid({0.F, -0.8F, 0.F}, {0.11F, 0.07F, 0.1F}, 8, cloth.upper);
      mesh.add_ellipsoid({0.12F, -0.785F, 0.F}, {0.08F, 0.012F, 0.075F}, 6, cloth.upper);
      break;
    case Outfit::Head::kHood:
      mesh.add_ellipsoid({-0.03F, -0.73F, 0.F}, {0.13F, 0.15F, 0.12F}, 10, cloth.upper);
      mesh.add_ellipsoid({-0.02F, -0.56F, 0.F}, {0.11F, 0.07F, 0.13F}, 8, cloth.upper);
      break;
  }
  return mesh;
}

Mesh foot(const Paint& shoe) {
  Mesh mesh;
  // The sole's distance below the ankle matches the gait's.
  mesh.add_ellipsoid({0.055F, 0.04F, 0.F}, {0.135F, static_cast<float>(kAnkle_m) - 0.04F, 0.046F}, 8, shoe);
  mesh.add_ellipsoid({-0.01F, 0.015F, 0.F}, {0.06F, 0.055F, 0.042F}, 6, shoe);
  return mesh;
}

}  // namespace

std::vector<Mesh> body_parts(std::uint16_t seed, const Outfit& outfit) {
  const Cloth cloth(seed, outfit);
  const Paint& thigh_paint = outfit.legs == Outfit::Legs::kBare ? cloth.skin : cloth.lower;
  const Paint& shin_paint = outfit.legs == Outfit::Legs::kTrousers ? cloth.lower : cloth.skin;
  std::vector<Mesh> parts(kPartCount);
  parts[kTorso] = torso(outfit, cloth);
  parts[kHead] = head(outfit, cloth);
  for (const BodyPart thigh : {kThighL, kThighR}) {
    parts[thigh] = limb(static_cast<float>(kThigh_m), 0.082F, 0.06F, thigh_paint);
  }
  for (const BodyPart shin : {kShinL, kShinR}) {
    parts[shin] = limb(static_cast<float>(kShin_m), 0.06F, 0.047F, shin_paint);
  }
  for (const BodyPart side : {kFootL, kFootR}) {
    parts[side] = foot(cloth.shoe);
  }
  for (const BodyPart arm : {kUpperArmL, kUpperArmR}) {
    parts[arm] = limb(static_cast<float>(kUpperArm_m), 0.052F, 0.043F, cloth.upper);
  }
  for (const BodyPart forearm : {kForearmL, kForearmR}) {
    parts[forearm] = limb(0.24F, 0.041F, 0.032F, outfit.long_sleeves ? cloth.upper : cloth.skin);
    parts[forearm].add_ellipsoid({0.01F, 0.3F, 0.F}, {0.04F, 0.075F, 0.02F}, 6, cloth.skin);
  }
  return parts;
}

Outfit random_outfit(Random& random) {
  const auto tone = [&](double low, double high) {
    return static_cast<float>(std::exp(random.uniform(std::log(low), std::log(high))));
  };
  Outfit outfit;
  outfit.girth = static_cast<float>(random.uniform(0.88, 1.3));
  outfit.plain = random.chance(0.6);
  outfit.long_sleeves = random.chance(0.55);
  const double cut = random.unit();
  if (cut < 0.15) {
    outfit.legs = Outfit::Legs::kShorts;
  } else if (cut < 0.4) {
    // A skirt or a dress, or a coat over bare legs or trousers.
    outfit.legs = random.chance(0.7) ? Outfit::Legs::kBare : Outfit::Legs::kTrousers;
    outfit.skirt_m = static_cast<float>(random.uniform(0.25, 0.75));
    outfit.is_dress = random.chance(0.6);
  } else if (cut < 0.55) {
    outfit.skirt_m = static_cast<float>(random.uniform(0.1, 0.5));
    outfit.is_dress = true;
    outfit.long_sleeves = true;
  }
  constexpr std::array kHeads{Outfit::Head::kShortHair, Outfit::Head::kShortHair, Outfit::Head::kLongHair,
                              Outfit::Head::kLongHair,  Outfit::Head::kCap,       Outfit::Head::kHood};
  outfit.head = kHeads[static_cast<std::size_t>(random.index(kHeads.size()))];
  if (random.chance(0.35)) {
    outfit.luggage = random.chance(0.5) ? Outfit::Luggage::kBackpack : Outfit::Luggage::kShoulderBag;
  }
  outfit.upper_tone = outfit.plain ? tone(0.4, 5.0) : tone(0.4, 2.5);
  outfit.lower_tone = tone(0.4, 3.5);
  outfit.hair_tone = tone(0.6, 4.0);
  return outfit;
}

}  // namespace kinetrace::simulator
