#include "world/clutter.hpp"

#include <array>
#include <cmath>

namespace kinetrace::simulator {
namespace {

using Eigen::Vector3f;

float uniform(Random& random, double low, double high) {
  return static_cast<float>(random.uniform(low, high));
}

std::uint16_t seed_of(Random& random) {
  return static_cast<std::uint16_t>(random.bits());
}

Paint any_paint(Random& random) {
  constexpr std::array<Material, 11> kMaterials{Material::kMetal,       Material::kWood,     Material::kPlain,
                                                Material::kConcrete,    Material::kPoster,   Material::kCardboard,
                                                Material::kSign,        Material::kTruckBox, Material::kPanelWall,
                                                Material::kBrickFacade, Material::kRoofTiles};
  return {kMaterials[static_cast<std::size_t>(random.index(kMaterials.size()))], seed_of(random), nullptr,
          random_tone(random)};
}

// On the ground, one above the other.
void stack_boxes(Mesh& mesh, Random& random, int count, const Vector3f& first) {
  Vector3f size = first;
  float low = 0.F;
  for (int i = 0; i < count; ++i) {
    mesh.add_box({0.F, -low - 0.5F * size.y(), 0.F}, size, any_paint(random));
    low += size.y();
    size =
        size.cwiseProduct(Vector3f(uniform(random, 0.5, 1.05), uniform(random, 0.2, 1.0), uniform(random, 0.5, 1.05)));
  }
}

Clutter bin(Random& random) {
  Clutter thing;
  const float wide = uniform(random, 0.4, 1.4);
  const float deep = uniform(random, 0.4, 0.9);
  const float tall = uniform(random, 0.6, 1.4);
  const Paint paint = any_paint(random);
  thing.mesh.add_box({0.F, -0.5F * tall, 0.F}, {deep, tall, wide}, paint);
  thing.mesh.add_box({0.F, -tall, 0.F}, {1.08F * deep, 0.07F, 1.08F * wide}, any_paint(random));
  for (const float z : {-0.4F, 0.4F}) {
    thing.mesh.add_cylinder({0.4F * deep, -0.1F, z * wide - 0.03F}, {0.4F * deep, -0.1F, z * wide + 0.03F}, 0.1F, 0.1F,
                            12, {Material::kTyre});
  }
  thing.half_m = {0.6F * deep, 0.6F * wide};
  return thing;
}

Clutter pole(Random& random) {
  Clutter thing;
  const float tall = random.chance(0.5) ? uniform(random, 0.6, 1.6) : uniform(random, 2.0, 7.0);
  const float radius = uniform(random, 0.03, 0.17);
  thing.mesh.add_cylinder({0.F, 0.F, 0.F}, {0.F, -tall, 0.F}, radius, uniform(random, 0.6, 1.0) * radius, 12,
                          any_paint(random));
  if (random.chance(0.5)) {
    const float wide = uniform(random, 0.2, 0.8);
    const Vector3f size(wide, uniform(random, 0.2, 1.0), 0.05F);
    thing.mesh.add_box({0.F, -tall + 0.4F * size.y(), 0.F}, size, any_paint(random),
                       turned(uniform(random, -1.6, 1.6)));
  }
  if (random.chance(0.3)) {
    thing.mesh.add_ellipsoid({0.F, -tall, 0.F}, Vector3f::Constant(uniform(random, 0.08, 0.3)), 8, any_paint(random));
  }
  thing.half_m = {0.45F, 0.45F};
  return thing;
}

Clutter board(Random& random) {
  Clutter thing;
  const float wide = uniform(random, 0.8, 3.5);
  const float tall = uniform(random, 0.6, 2.4);
  const float low = uniform(random, 0.1, 1.2);
  thing.mesh.add_box({0.F, -low - 0.5F * tall, 0.F}, {0.1F, tall, wide}, any_paint(random));
  for (const float z : {-0.35F, 0.35F}) {
    thing.mesh.add_cylinder({0.F, 0.F, z * wide}, {0.F, -low - tall, z * wide}, 0.05F, 0.05F, 8, any_paint(random));
  }
  thing.half_m = {0.2F, 0.55F * wide};
  return thing;
}

// From a crate to a container as large as a van.
Clutter boxes(Random& random) {
  Clutter thing;
  const float large = std::exp(uniform(random, -1.2, 1.1));
  const Vector3f size(uniform(random, 0.7, 1.0) * large, uniform(random, 0.4, 0.8) * large,
                      uniform(random, 0.7, 2.0) * large);
  stack_boxes(thing.mesh, random, 1 + random.index(3), size);
  thing.half_m = {0.6F * size.x(), 0.6F * size.z()};
  return thing;
}

Clutter bush(Random& random) {
  Clutter thing;
  const float large = uniform(random, 0.4, 1.4);
  const bool plant = random.chance(0.8);
  for (int i = 0; i < 4; ++i) {
    const float radius = large * uniform(random, 0.5, 0.9);
    const Paint paint =
        plant ? Paint{Material::kFoliage, seed_of(random), nullptr, random_tone(random)} : any_paint(random);
    thing.mesh.add_ellipsoid({uniform(random, -0.5, 0.5) * large, -0.6F * radius, uniform(random, -0.5, 0.5) * large},
                             {radius, radius * uniform(random, 0.7, 1.3), radius}, 9, paint, plant ? 0.2F : 0.05F);
  }
  thing.half_m = {1.5F * large, 1.5F * large};
  return thing;
}

Clutter cone(Random& random) {
  Clutter thing;
  const float tall = uniform(random, 0.4, 1.2);
  const float radius = uniform(random, 0.15, 0.5);
  thing.mesh.add_cylinder({0.F, 0.F, 0.F}, {0.F, -tall, 0.F}, radius, uniform(random, 0.1, 1.0) * radius, 14,
                          any_paint(random));
  thing.half_m = {1.2F * radius, 1.2F * radius};
  return thing;
}

Clutter bench(Random& random) {
  Clutter thing;
  const float wide = uniform(random, 1.0, 2.2);
  const float tall = uniform(random, 0.4, 0.8);
  const Paint paint = any_paint(random);
  thing.mesh.add_box({0.F, -tall, 0.F}, {0.5F, 0.07F, wide}, paint);
  for (const float z : {-0.4F, 0.4F}) {
    thing.mesh.add_box({0.F, -0.5F * tall, z * wide}, {0.4F, tall, 0.08F}, paint);
  }
  if (random.chance(0.6)) {
    thing.mesh.add_box({0.25F, -1.6F * tall, 0.F}, {0.06F, 0.6F * tall, wide}, paint);
  }
  thing.half_m = {0.4F, 0.6F * wide};
  return thing;
}

}  // namespace

float random_tone(Random& random) {
  return std::exp(uniform(random, -1.5, 0.8));
}

Mesh toned(Mesh mesh, float tone) {
  for (Mesh::Triangle& triangle : mesh.triangles) {
    triangle.paint.tone = tone;
  }
  return mesh;
}

Clutter random_clutter(Random& random) {
  constexpr std::array<Clutter (*)(Random&), 7> kMakers{bin, pole, board, boxes, bush, cone, bench};
  return kMakers[static_cast<std::size_t>(random.index(kMakers.size()))](random);
}

}  // namespace kinetrace::simulator
