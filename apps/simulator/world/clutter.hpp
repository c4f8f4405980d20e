// Objects in streets that are neither vehicles nor people.
#pragma once

#include <Eigen/Core>

#include "util/random.hpp"
#include "world/mesh.hpp"

namespace kinetrace::simulator {

/// An object standing on the ground at the origin.
struct Clutter {
  Mesh mesh;
  Eigen::Vector2f half_m = Eigen::Vector2f::Zero();  ///< Of the square around it, along x and z.
};

/// A bin, post, pole, sign, board, crate, container, bush, cabinet, cone, bench, heap or hut, of any size and look.
[[nodiscard]] Clutter random_clutter(Random& random);

/// A random factor for albedos, as often below 1 as above.
[[nodiscard]] float random_tone(Random& random);

/// Gives all of a mesh the same tone.
[[nodiscard]] Mesh toned(Mesh mesh, float tone);

}  // namespace kinetrace::simulator
