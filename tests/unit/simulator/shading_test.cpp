// Points are shaded equally on every machine, and in any batch.
#include <algorithm>
#include <vector>

#include <gtest/gtest.h>

#include "kinetrace/core/cpu.hpp"
#include "rendering/shading_queue.hpp"
#include "util/random.hpp"

namespace kinetrace::simulator {
namespace {

constexpr int kMaterials = static_cast<int>(Material::kPlain) + 1;
const BodyShape kShape;

Paint paint_of(int material, std::uint16_t seed) {
  return {static_cast<Material>(material), seed, &kShape};
}

Eigen::Vector3f random_vector(Random& random, double size) {
  return Eigen::Vector3d(random.uniform(-size, size), random.uniform(-size, size), random.uniform(-size, size))
      .cast<float>();
}

ShadedPoint random_point(Random& random) {
  ShadedPoint point;
  point.local.position = random_vector(random, 3.0);
  point.local.normal = random_vector(random, 1.0).normalized();
  point.local.uv = random_vector(random, 5.0).head<2>();
  point.footprint_m = static_cast<float>(random.uniform(0.0005, 0.2));
  point.normal = random_vector(random, 1.0).normalized();
  point.ray = random_vector(random, 2.0);
  point.in_sun = static_cast<float>(random.unit());
  return point;
}

TEST(ShadingQueue, ShadesEachPointAsIfItWereAlone) {
  Random random(3, 1);
  std::vector<Paint> paints;
  std::vector<ShadedPoint> points;
  for (int i = 0; i < 40 * kMaterials; ++i) {
    paints.push_back(paint_of(random.index(kMaterials), static_cast<std::uint16_t>(random.index(3))));
    points.push_back(random_point(random));
  }
  ShadingQueue queue{Light{}};
  std::vector<float> together(points.size());
  for (std::size_t i = 0; i < points.size(); ++i) {
    queue.add(paints[i], points[i], 0.5F, together[i]);
  }
  queue.finish();
  for (std::size_t i = 0; i < points.size(); ++i) {
    float alone = 0.F;
    queue.add(paints[i], points[i], 0.5F, alone);
    queue.finish();
    EXPECT_EQ(together[i], alone) << "point " << i << ", material " << static_cast<int>(paints[i].material);
    EXPECT_GT(alone, 0.F);
  }
}

TEST(ShadingQueue, AddsThePartsOfAPixelByTheirWeights) {
  ShadingQueue queue{Light{}};
  Random random(5, 1);
  const Paint paint = paint_of(static_cast<int>(Material::kConcrete), 1);
  const ShadedPoint point = random_point(random);
  float whole = 0.F;
  queue.add(paint, point, 1.F, whole);
  queue.add_sky({0.1F, -0.3F, 1.F}, 1.F, whole);
  float halves = 0.F;
  for (int i = 0; i < 2; ++i) {
    queue.add(paint, point, 0.5F, halves);
    queue.add_sky({0.1F, -0.3F, 1.F}, 0.5F, halves);
  }
  queue.finish();
  EXPECT_GT(whole, 0.F);
  EXPECT_FLOAT_EQ(whole, halves);
}

TEST(ShadingQueue, ShadesAStripLikeItsPoints) {
  ShadingQueue queue{Light{}};
  Random random(6, 1);
  std::vector<float> by_strips(3);
  std::vector<float> by_points(3);
  const Paint paint = paint_of(static_cast<int>(Material::kBrickFacade), 1);
  for (std::size_t i = 0; i < by_strips.size(); ++i) {
    ShadedPoint point = random_point(random);
    SurfaceStrip strip;
    for (StripLanes* lanes : {&strip.ray.x, &strip.ray.y, &strip.ray.z, &strip.position.x, &strip.position.y,
                              &strip.position.z, &strip.u, &strip.v}) {
      *lanes = StripLanes::NullaryExpr([&] { return static_cast<float>(random.uniform(-2.0, 2.0)); });
    }
    queue.add_strip(paint, point, strip, 0.25F, by_strips[i]);
    for (std::size_t lane = 0; lane < kStripLanes; ++lane) {
      point.ray = strip.ray.at(lane);
      point.local.position = strip.position.at(lane);
      point.local.uv = strip.uv_at(lane);
      queue.add(paint, point, 0.25F, by_points[i]);
    }
  }
  queue.finish();
  EXPECT_GT(by_strips[0], 0.F);
  EXPECT_EQ(by_strips, by_points);
}

SurfacePack random_pack(Random& random) {
  SurfacePack pack;
  for (std::size_t lane = 0; lane < kLanes; ++lane) {
    const ShadedPoint point = random_point(random);
    pack.position.set(lane, 20.F * point.local.position);
    pack.normal.set(lane, point.local.normal);
    pack.u[lane] = point.local.uv.x();
    pack.v[lane] = point.local.uv.y();
    pack.footprint_m[lane] = point.footprint_m;
    pack.scene_normal.set(lane, point.normal);
    pack.ray.set(lane, point.ray);
    pack.in_sun[lane] = point.in_sun;
  }
  return pack;
}

TEST(ShadingKernel, GivesTheSameOnEveryInstructionSet) {
  if (!cpu_runs_fast_kernels()) {
    GTEST_SKIP() << "only one instruction set is in use here";
  }
  Random random(7, 1);
  const Daylight light{{-0.48F, -0.8F, -0.36F}, 1.F, 0.38F, 1.1F};
  for (int i = 0; i < 60 * kMaterials; ++i) {
    const Paint paint = paint_of(i % kMaterials, static_cast<std::uint16_t>(random.index(9)));
    const SurfacePack pack = random_pack(random);
    Lanes portable;
    Lanes quick;
    kernel_baseline::shading_kernel.shade(paint, pack, light, portable);
    kernel_fast::shading_kernel.shade(paint, pack, light, quick);
    EXPECT_EQ(portable, quick) << "material " << i % kMaterials;
    kernel_baseline::shading_kernel.shade_sky(pack.ray, light, portable);
    kernel_fast::shading_kernel.shade_sky(pack.ray, light, quick);
    EXPECT_EQ(portable, quick);
  }
}

}  // namespace
}  // namespace kinetrace::simulator
