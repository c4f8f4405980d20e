// A person's body parts and clothes: rigid, each in the frame of its joint.
#pragma once

#include <cstdint>
#include <vector>

#include "util/random.hpp"
#include "world/mesh.hpp"

namespace kinetrace::simulator {

enum BodyPart : std::size_t {
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

inline constexpr double kUpperArm_m = 0.29;

/// A person's appearance; by default a shirt with short sleeves, trousers, short hair, nothing carried.
struct Outfit {
  enum class Legs : std::uint8_t { kTrousers, kShorts, kBare };
  enum class Head : std::uint8_t { kShortHair, kLongHair, kCap, kHood };
  enum class Luggage : std::uint8_t { kNone, kBackpack, kShoulderBag };

  float girth = 1.F;   ///< Of the trunk, relative to the usual one.
  bool plain = false;  ///< A shirt without stripes, checks or print.
  bool long_sleeves = false;
  Legs legs = Legs::kTrousers;
  float skirt_m = 0.F;    ///< Length of a skirt, dress or coat below the hip; 0: none.
  bool is_dress = false;  ///< The skirt is of the shirt's cloth.
  Head head = Head::kShortHair;
  Luggage luggage = Luggage::kNone;
  float upper_tone = 1.F;  ///< Factors to the albedo of shirt, trousers or skirt, and hair.
  float lower_tone = 1.F;
  float hair_tone = 1.F;
};

/// Summer and winter clothes, skirts, coats, caps, hoods and bags, of any brightness.
[[nodiscard]] Outfit random_outfit(Random& random);

/// One mesh for each BodyPart. `seed`: colours and patterns. Torso and head have their origin in the middle of the hip;
/// limbs hang from their joint at the origin, y down.
[[nodiscard]] std::vector<Mesh> body_parts(std::uint16_t seed, const Outfit& outfit = {});

}  // namespace kinetrace::simulator
