// Vehicles and worlds drawn at random for training.
#include <algorithm>
#include <cmath>
#include <set>
#include <vector>

#include <Eigen/Geometry>
#include <gtest/gtest.h>

#include "scenes/scenes.hpp"
#include "small_simulator.hpp"
#include "world/body.hpp"
#include "world/clutter.hpp"
#include "world/random_vehicle.hpp"

namespace kinetrace::simulator {
namespace {

Eigen::AlignedBox3f box_of(const Mesh& mesh) {
  Eigen::AlignedBox3f box;
  for (const Mesh::Vertex& vertex : mesh.vertices) {
    box.extend(vertex.position);
  }
  return box;
}

TEST(RandomVehicle, StandsOnTheGroundInsideItsBox) {
  constexpr float kMirror_m = 0.2F;
  constexpr float kDoor_m = 1.25F;
  for (std::uint32_t seed = 0; seed < 200; ++seed) {
    Random random(seed);
    const RandomVehicle vehicle = random_vehicle(random);
    const Eigen::AlignedBox3f box = box_of(vehicle.mesh);
    const Eigen::Vector3f half_m = 0.5F * vehicle.size_lhw_m;
    EXPECT_NEAR(box.max().y(), 0.F, 0.01F) << seed;
    EXPECT_NEAR(-box.min().y(), vehicle.size_lhw_m.y(), 0.02F) << seed;
    EXPECT_NEAR(box.max().x(), half_m.x(), 0.05F) << seed;
    EXPECT_NEAR(box.min().x(), -half_m.x(), 0.12F) << seed;
    const float reach_m = std::max(box.max().z(), -box.min().z());
    EXPECT_LT(reach_m, half_m.z() + (vehicle.doorway_m ? kDoor_m : kMirror_m)) << seed;
    EXPECT_GT(reach_m, half_m.z() - 0.1F) << seed;
  }
}

TEST(RandomVehicle, ComesInManySizes) {
  std::vector<float> lengths_m;
  std::vector<float> heights_m;
  for (std::uint32_t seed = 0; seed < 200; ++seed) {
    Random random(seed);
    const RandomVehicle vehicle = random_vehicle(random);
    lengths_m.push_back(vehicle.size_lhw_m.x());
    heights_m.push_back(vehicle.size_lhw_m.y());
  }
  EXPECT_LT(*std::min_element(lengths_m.begin(), lengths_m.end()), 3.8F);
  EXPECT_GT(*std::max_element(lengths_m.begin(), lengths_m.end()), 9.F);
  EXPECT_LT(*std::min_element(heights_m.begin(), heights_m.end()), 1.35F);
  EXPECT_GT(*std::max_element(heights_m.begin(), heights_m.end()), 2.8F);
}

TEST(RandomOutfit, HangsFromTheBodyAndReachesNoGround) {
  constexpr float kHipAboveGround_m = 0.86F;  // On straight legs, as far as the ankle.
  int skirts = 0;
  int bags = 0;
  for (std::uint32_t seed = 0; seed < 200; ++seed) {
    Random random(seed);
    const Outfit outfit = random_outfit(random);
    const std::vector<Mesh> parts = body_parts(static_cast<std::uint16_t>(seed), outfit);
    ASSERT_EQ(parts.size(), std::size_t{kPartCount});
    const Eigen::AlignedBox3f torso = box_of(parts[kTorso]);
    EXPECT_GE(torso.max().y(), outfit.skirt_m) << seed;
    EXPECT_LT(torso.max().y(), kHipAboveGround_m) << seed;
    EXPECT_LT(torso.max().x() - torso.min().x(), 0.8F) << seed;
    EXPECT_LT(torso.max().z() - torso.min().z(), 0.9F) << seed;
    EXPECT_GT(-box_of(parts[kHead]).min().y(), 0.84F) << seed;
    skirts += outfit.skirt_m > 0.F ? 1 : 0;
    bags += outfit.luggage != Outfit::Luggage::kNone ? 1 : 0;
  }
  EXPECT_GT(skirts, 40);
  EXPECT_LT(skirts, 160);
  EXPECT_GT(bags, 30);
}

TEST(RandomOutfit, WithoutOneSomebodyWearsShirtAndTrousers) {
  const std::vector<Mesh> plain = body_parts(7);
  const Eigen::AlignedBox3f torso = box_of(plain[kTorso]);
  EXPECT_NEAR(torso.max().y(), 0.09F, 1e-5F);
  for (const Mesh::Triangle& triangle : plain[kShinL].triangles) {
    EXPECT_EQ(triangle.paint.material, Material::kTrousers);
  }
  for (const Mesh::Triangle& triangle : plain[kForearmL].triangles) {
    EXPECT_EQ(triangle.paint.material, Material::kSkin);
  }
}

TEST(RandomVehicle, OfTheSameSeedIsTheSame) {
  Random first(7);
  Random second(7);
  const RandomVehicle a = random_vehicle(first);
  const RandomVehicle b = random_vehicle(second);
  EXPECT_EQ(a.size_lhw_m, b.size_lhw_m);
  EXPECT_EQ(a.mesh.vertices.size(), b.mesh.vertices.size());
}

TEST(RandomClutter, StandsOnTheGroundInsideItsSquare) {
  for (std::uint32_t seed = 0; seed < 300; ++seed) {
    Random random(seed);
    const Clutter thing = random_clutter(random);
    const Eigen::AlignedBox3f box = box_of(thing.mesh);
    EXPECT_GE(box.max().y(), -0.01F) << seed;
    EXPECT_LE(std::max(box.max().x(), -box.min().x()), thing.half_m.x() + 0.5F) << seed;
    EXPECT_LE(std::max(box.max().z(), -box.min().z()), thing.half_m.y() + 0.5F) << seed;
  }
}

TEST(Varied, LooksFromElsewhereInEveryFrame) {
  for (const std::uint32_t world : {1U, 2U, 3U}) {
    const Scene scene = make_scene("varied", world).value();
    for (int frame = 1; frame < scene.frames; ++frame) {
      const Se3 before = scene.T_scene_cam((frame - 1) / scene.rate_hz);
      const Se3 now = scene.T_scene_cam(frame / scene.rate_hz);
      EXPECT_GT(
          (now.translation - before.translation).norm() + so3_log(before.rotation.transpose() * now.rotation).norm(),
          0.01)
          << "world " << world << ", frame " << frame;
    }
  }
}

TEST(Varied, ShowsVehiclesAndPeople) {
  std::set<std::uint16_t> classes;
  int visible = 0;
  for (const std::uint32_t world : {2U, 3U, 4U, 5U}) {
    StereoSimulator simulator = small_simulator("varied", clean_settings(), 414, world);
    for (const int frame : {0, 5}) {
      for (const ObjectTruth& object : simulator.frame(frame).objects) {
        if (object.visible_px > 0) {
          ++visible;
          classes.insert(object.class_id);
        }
      }
    }
  }
  EXPECT_GT(visible, 60);
  EXPECT_EQ(classes, (std::set<std::uint16_t>{kVehicleClass, kPedestrianClass}));
}

}  // namespace
}  // namespace kinetrace::simulator
