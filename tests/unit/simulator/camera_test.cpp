// Lenses, sensor and noise.
#include <algorithm>
#include <cmath>
#include <set>
#include <vector>

#include <gtest/gtest.h>

#include "camera/camera_rig.hpp"
#include "camera/sensor.hpp"
#include "camera/sensor_kernel.hpp"
#include "kinetrace/core/cpu.hpp"
#include "shading/noise.hpp"
#include "util/random.hpp"

namespace kinetrace::simulator {
namespace {

const StereoGeometry kRig{721.5, 721.5, 609.6, 172.9, 0.54, 1242, 375};

TEST(RawCamera, RaysAndPixelsAreInverse) {
  for (const RawCamera& camera : distorted_rig(kRig).raw) {
    for (const Eigen::Vector2d& pixel : {Eigen::Vector2d(3.0, 5.0), Eigen::Vector2d(700.0, 250.0),
                                         Eigen::Vector2d(1380.0, 20.0), Eigen::Vector2d(10.0, 505.0)}) {
      const Eigen::Vector2d ray = camera.rectified_ray(pixel);
      EXPECT_LT((camera.project(ray.homogeneous()) - pixel).norm(), 1e-6);
    }
  }
}

TEST(RawCamera, CoversTheWholeRectifiedPicture) {
  for (const StereoGeometry& geometry : {kRig, StereoGeometry{458.0, 458.0, 375.5, 239.5, 0.2, 752, 480},
                                         StereoGeometry{400, 400, 319.5, 239.5, 0.1, 640, 480}}) {
    for (const RawCamera& camera : distorted_rig(geometry).raw) {
      for (const int x : {0, geometry.width_px / 2, geometry.width_px - 1}) {
        for (const int y : {0, geometry.height_px / 2, geometry.height_px - 1}) {
          const Eigen::Vector2d raw =
              camera.project({(x - geometry.cx_px) / geometry.fx_px, (y - geometry.cy_px) / geometry.fy_px, 1.0});
          EXPECT_GE(raw.x(), 0.0) << x << ' ' << y;
          EXPECT_GE(raw.y(), 0.0) << x << ' ' << y;
          EXPECT_LE(raw.x(), camera.width_px - 1.0) << x << ' ' << y;
          EXPECT_LE(raw.y(), camera.height_px - 1.0) << x << ' ' << y;
        }
      }
    }
  }
}

TEST(SampleRays, NoTwoSamplesShareARowOrAColumn) {
  const StereoGeometry small{100.0, 100.0, 1.5, 1.5, 0.1, 4, 4};
  const SampleRays rays(ideal_rig(small).raw[0], 3);
  ASSERT_EQ(rays.samples(), 9);
  std::set<int> columns;
  std::set<int> rows;
  Eigen::Vector2f mean = Eigen::Vector2f::Zero();
  for (int s = 0; s < 9; ++s) {
    // In ninths of the pixel (2, 1).
    const Eigen::Vector2f at = rays.at(2, 1, s) * 100.F + Eigen::Vector2f(1.5F - 2.F, 1.5F - 1.F);
    columns.insert(static_cast<int>(std::floor((at.x() + 0.5F) * 9.F)));
    rows.insert(static_cast<int>(std::floor((at.y() + 0.5F) * 9.F)));
    mean += at / 9.F;
  }
  EXPECT_EQ(columns.size(), 9U);
  EXPECT_EQ(rows.size(), 9U);
  EXPECT_LT(mean.norm(), 1e-4F);
}

// A pinhole's rays are kept by column and row, others pixel by pixel.
TEST(SampleRays, AreThoseOfTheCamera) {
  const StereoGeometry small = resized(kRig, 60, std::nullopt);
  for (const RawCamera& camera : {ideal_rig(small).raw[0], distorted_rig(small).raw[1]}) {
    const SampleRays rays(camera, 2);
    for (int y = 0; y < camera.height_px; ++y) {
      for (int x = 0; x < camera.width_px; ++x) {
        const Eigen::Vector2d centre(x, y);
        ASSERT_EQ(rays.centre(x, y), camera.rectified_ray(centre).cast<float>()) << x << ' ' << y;
        ASSERT_EQ(rays.at(x, y, 0), camera.rectified_ray(centre + Eigen::Vector2d(-0.125, -0.375)).cast<float>());
        ASSERT_EQ(rays.at(x, y, 3), camera.rectified_ray(centre + Eigen::Vector2d(0.125, 0.375)).cast<float>());
      }
    }
  }
}

TEST(ResizedRig, KeepsTheFieldOfView) {
  const StereoGeometry half = resized(kRig, 621, std::nullopt);
  EXPECT_EQ(half.height_px, 188);
  EXPECT_DOUBLE_EQ(half.fx_px, 0.5 * kRig.fx_px);
  EXPECT_DOUBLE_EQ((half.cx_px + 0.5) / half.fx_px, (kRig.cx_px + 0.5) / kRig.fx_px);
  const StereoGeometry taller = resized(kRig, std::nullopt, 475);
  EXPECT_DOUBLE_EQ(taller.fx_px, kRig.fx_px);
  EXPECT_DOUBLE_EQ(taller.cy_px, kRig.cy_px + 50.0);
}

TEST(Sensor, AddsTheNoiseThatIsSet) {
  const Image<float> grey(200, 100, 0.2520F);  // The square of 128 / 255.
  const SensorSettings settings{.noise_levels = 2.0, .vignetting = 0.0, .blur_px = 0.0, .right_gain = 1.0};
  const Image<std::uint8_t> image = expose(grey, settings, 1.0, 1, 2);
  double sum = 0.0;
  double squares = 0.0;
  for (const std::uint8_t level : image.pixels()) {
    sum += level;
    squares += (level - 128.0) * (level - 128.0);
  }
  EXPECT_NEAR(sum / 20000.0, 128.0, 0.1);
  // Rounding to whole levels adds a twelfth.
  EXPECT_NEAR(std::sqrt(squares / 20000.0), std::sqrt(4.0 + 1.0 / 12.0), 0.06);
}

TEST(Sensor, DarkensTheCornersAndKeepsTheMiddle) {
  const Image<float> grey(101, 101, 0.25F);
  const SensorSettings settings{.noise_levels = 0.0, .vignetting = 0.36, .blur_px = 0.0, .right_gain = 1.0};
  const Image<std::uint8_t> image = expose(grey, settings, 1.0, 1, 1);
  EXPECT_EQ(image.at(50, 50), 128);
  // A square root of the light: sqrt(1 - 0.36) = 0.8.
  EXPECT_NEAR(image.at(0, 0), 0.8 * 127.5, 1.0);
}

TEST(Sensor, BlursWithoutChangingTheMean) {
  Image<float> point(21, 21, 0.F);
  point.at(10, 10) = 1.F;
  const SensorSettings settings{.noise_levels = 0.0, .vignetting = 0.0, .blur_px = 0.5, .right_gain = 1.0};
  const Image<std::uint8_t> image = expose(point, settings, 1.0, 1, 1);
  double light = 0.0;
  for (const std::uint8_t level : image.pixels()) {
    light += level / 255.0 * (level / 255.0);
  }
  EXPECT_NEAR(light, 1.0, 0.03);
  EXPECT_LT(image.at(10, 10), 250);
  EXPECT_EQ(image.at(11, 10), image.at(9, 10));
  EXPECT_GT(image.at(11, 10), 50);
}

TEST(Sensor, ExposesTheSameOnEveryInstructionSet) {
  if (!cpu_runs_fast_kernels()) {
    GTEST_SKIP() << "only one instruction set is in use here";
  }
  Random random(1, 3);
  constexpr int kWidth = 1003;  // Not a multiple of eight.
  std::vector<float> radiance(kWidth);
  std::generate(radiance.begin(), radiance.end(), [&] { return static_cast<float>(random.uniform(-0.1, 1.4)); });
  const RowExposure row{1.1F, 500.F, -70.F, 4e-7F, 1.5F, 99U};
  std::vector<std::uint8_t> portable(kWidth);
  std::vector<std::uint8_t> quick(kWidth);
  kernel_baseline::expose_row(radiance.data(), kWidth, row, portable.data());
  kernel_fast::expose_row(radiance.data(), kWidth, row, quick.data());
  EXPECT_EQ(portable, quick);
  EXPECT_GT(std::set(portable.begin(), portable.end()).size(), 100U);
}

// All lanes at one point.
float noise_at(const Octaves& octaves, const Eigen::Vector3f& point, float footprint_m) {
  Lanes3 points;
  Lanes footprints;
  for (std::size_t i = 0; i < kLanes; ++i) {
    points.set(i, point);
    footprints[i] = footprint_m;
  }
  return fractal_noise(octaves, points, footprints).back();
}

TEST(Noise, HasZeroMeanAndUnitVariance) {
  const Octaves octaves(0.7F, 0.8F, 8, 5);
  Random random(1, 2);
  double sum = 0.0;
  double squares = 0.0;
  constexpr int kCount = 40000;
  for (int i = 0; i < kCount; ++i) {
    const Eigen::Vector3f at(static_cast<float>(random.uniform(-90, 90)), static_cast<float>(random.uniform(-90, 90)),
                             static_cast<float>(random.uniform(-90, 90)));
    const double value = static_cast<double>(noise_at(octaves, at, 0.F));
    sum += value;
    squares += value * value;
  }
  EXPECT_NEAR(sum / kCount, 0.0, 0.03);
  EXPECT_NEAR(squares / kCount, 1.0, 0.05);
}

TEST(Noise, FadesWhatAPixelCannotResolve) {
  const Octaves octaves(0.1F, 0.9F, 6, 5);
  for (float x = 0.F; x < 1.F; x += 0.013F) {
    EXPECT_EQ(noise_at(octaves, {x, 0.4F, 2.F}, 0.1F), 0.F);
  }
}

TEST(Noise, IsContinuous) {
  const Octaves octaves(0.5F, 0.8F, 5, 5);
  float previous = noise_at(octaves, {-1.F, 0.3F, 0.2F}, 0.F);
  for (int i = 1; i < 4000; ++i) {
    const float value = noise_at(octaves, {-1.F + 0.0005F * static_cast<float>(i), 0.3F, 0.2F}, 0.F);
    EXPECT_LT(std::abs(value - previous), 0.15F);
    previous = value;
  }
}

TEST(Noise, DoesNotDependOnWhatStandsInTheOtherLanes) {
  const Octaves octaves(0.5F, 0.8F, 8, 5);
  Lanes3 points;
  Lanes footprints;
  for (std::size_t i = 0; i < kLanes; ++i) {
    const auto step = static_cast<float>(i);
    points.set(i, {3.1F * step, 7.F - step, 0.3F * step});
    footprints[i] = 0.03F * step;
  }
  const Lanes together = fractal_noise(octaves, points, footprints);
  for (std::size_t i = 0; i < kLanes; ++i) {
    EXPECT_EQ(together[i], noise_at(octaves, {points.x[i], points.y[i], points.z[i]}, footprints[i]));
  }
}

}  // namespace
}  // namespace kinetrace::simulator
