// The same kernels compiled for different instruction sets must agree, so that every board gives the same result.
#include <algorithm>
#include <iterator>
#include <vector>

#include <gtest/gtest.h>

#include "feature_slot.hpp"
#include "image_pyramid.hpp"
#include "kernels.hpp"
#include "kinetrace/core/cpu.hpp"
#include "synthetic_scene.hpp"

namespace kinetrace::features {
namespace {

class KernelVariants : public ::testing::Test {
 protected:
  static constexpr int kWidth = 200;
  static constexpr int kHeight = 120;

  void SetUp() override {
    if (!cpu_runs_fast_kernels()) {
      GTEST_SKIP() << "only one instruction set is in use here";
    }
    const testing::Texture texture(5);
    const testing::Image image = testing::render(
        kWidth, kHeight, [&](const Eigen::Vector2d& p) { return texture(p); }, 2.0);
    std::vector<std::uint16_t> scratch(kWidth + 32);
    pyramid_ = ImagePyramid(arena_, kWidth, kHeight, 2);
    pyramid_.build(image.view(), scratch);
  }

  const Kernels& fast_ = kernels();
  const Kernels& plain_ = baseline_kernels();
  Arena arena_{std::size_t{1} << 20};
  ImagePyramid pyramid_;
};

TEST_F(KernelVariants, DownsampleToTheSamePixels) {
  const Plane source = pyramid_.level(0);
  std::vector<std::uint16_t> scratch(kWidth + 32);
  std::vector<std::uint8_t> a(std::size_t{kWidth / 2} * (kHeight / 2));
  std::vector<std::uint8_t> b(a.size());
  fast_.pyramid.downsample(source, a.data(), kWidth / 2, kHeight / 2, kWidth / 2, scratch.data());
  plain_.pyramid.downsample(source, b.data(), kWidth / 2, kHeight / 2, kWidth / 2, scratch.data());
  EXPECT_EQ(a, b);
}

TEST_F(KernelVariants, DifferentiateToTheSamePixels) {
  std::vector<std::uint8_t> a(std::size_t{kWidth} * kHeight);
  std::vector<std::uint8_t> b(a.size());
  fast_.pyramid.horizontal_gradient(pyramid_.level(0), a.data(), kWidth);
  plain_.pyramid.horizontal_gradient(pyramid_.level(0), b.data(), kWidth);
  EXPECT_EQ(a, b);
}

TEST_F(KernelVariants, WarpToTheSamePixels) {
  const Plane source = pyramid_.level(0);
  std::vector<WarpNode> nodes(kWidth / kWarpBlock + 2);
  for (std::size_t i = 0; i < nodes.size(); ++i) {
    nodes[i] = {static_cast<float>(kWarpBlock * i) * 1.004F - 3.3F, 20.7F + 0.11F * static_cast<float>(i)};
  }
  std::vector<std::uint8_t> a(kWidth);
  std::vector<std::uint8_t> b(kWidth);
  fast_.warp.warp_row(source, nodes.data(), kWidth, a.data());
  plain_.warp.warp_row(source, nodes.data(), kWidth, b.data());
  for (std::size_t i = 0; i < a.size(); ++i) {
    EXPECT_NEAR(a[i], b[i], 1) << i;
  }
}

TEST_F(KernelVariants, AlignToTheSamePosition) {
  const Plane image = pyramid_.level(0);
  const PatchWarp warp{0.95F, 0.03F, -0.02F, 1.04F};
  const AlignOptions options{10, 0.01F, 5.F, 0.F, 0.F};
  PatchMask left_part{{}, false};
  std::fill(std::begin(left_part.rows), std::end(left_part.rows), std::uint16_t{0x0FFF});
  PatchTemplate patch{};
  for (int i = 0; i < 12; ++i) {
    const float x = 20.F + 13.3F * static_cast<float>(i);
    const PatchMask& mask = i % 2 == 0 ? kWholePatch : left_part;
    PatchWarp warps[2] = {warp, warp};
    float positions[2][2] = {};
    PatchFit fits[2] = {};
    int k = 0;
    for (const Kernels* set : {&fast_, &plain_}) {
      ASSERT_TRUE(set->patch_template.sample_warped(image, x, 60.4F, warp, mask, &patch));
      positions[k][0] = x + 1.2F;
      positions[k][1] = 59.7F;
      ASSERT_TRUE(set->patch.align(image, patch, options, &positions[k][0], &positions[k][1]));
      fits[k] = set->patch.refine_warp(image, patch, positions[k][0], positions[k][1], {7000.F, false}, &warps[k]);
      ++k;
    }
    EXPECT_NEAR(positions[0][0], positions[1][0], 2e-3F);
    EXPECT_NEAR(positions[0][1], positions[1][1], 2e-3F);
    EXPECT_NEAR(fits[0].correlation, fits[1].correlation, 1e-3F);
    EXPECT_NEAR(warps[0].xx, warps[1].xx, 1e-3F);
    EXPECT_NEAR(warps[0].yx, warps[1].yx, 1e-3F);
  }
}

TEST_F(KernelVariants, NarrowToTheSameWindow) {
  const Plane image = pyramid_.level(0);
  const AlignOptions options{10, 0.003F, 5.F, 0.F, 0.F};
  PatchMask left_part{{}, false};
  std::fill(std::begin(left_part.rows), std::end(left_part.rows), std::uint16_t{0x0FFF});
  PatchTemplate patch{};
  for (int i = 0; i < 12; ++i) {
    const float x = 20.F + 13.3F * static_cast<float>(i);
    float positions[2][2] = {};
    int k = 0;
    for (const Kernels* set : {&fast_, &plain_}) {
      set->patch_template.sample(image, x, 60.4F, i % 2 == 0 ? kWholePatch : left_part, &patch);
      set->patch_template.narrow(&patch);
      positions[k][0] = x + 0.7F;
      positions[k][1] = 59.9F;
      ASSERT_TRUE(set->patch.align(image, patch, options, &positions[k][0], &positions[k][1]));
      ++k;
    }
    EXPECT_NEAR(positions[0][0], positions[1][0], 2e-3F);
    EXPECT_NEAR(positions[0][1], positions[1][1], 2e-3F);
  }
}

TEST_F(KernelVariants, SearchToTheSameOffset) {
  PatchTemplate patch{};
  for (const Kernels* set : {&fast_, &plain_}) {
    set->patch_template.sample(pyramid_.level(1), 50.F, 30.F, kWholePatch, &patch);
    const OffsetMatch match = set->search.correlate(pyramid_.level(1), patch, 45, 33, 8, 6);
    // Whole pixels on the one side, halves on the other: the centre of a patch lies between columns.
    EXPECT_NEAR(static_cast<float>(match.dx), 4.5F, 0.6F);
    EXPECT_EQ(match.dy, -3);
    EXPECT_GT(match.correlation, 0.9F);
  }
}

TEST_F(KernelVariants, CostTheSameAlongARow) {
  for (const int count : {1, 16, 17, 31, 32, 33, 100}) {
    std::vector<std::uint16_t> a(static_cast<std::size_t>(count));
    std::vector<std::uint16_t> b(a.size());
    const Plane image = pyramid_.level(0);
    fast_.search.row_costs(image, 90, 40, image, 41, 30, count, a.data());
    plain_.search.row_costs(image, 90, 40, image, 41, 30, count, b.data());
    EXPECT_EQ(a, b) << count;
    for (int k = 0; k < count; ++k) {
      int expected = 0;
      for (int dy = -5; dy <= 5; ++dy) {
        for (int dx = -7; dx <= 8; ++dx) {
          expected += std::abs(image.data[(40 + dy) * image.stride + 90 + dx] -
                               image.data[(41 + dy) * image.stride + 30 + k + dx]);
        }
      }
      ASSERT_EQ(a[static_cast<std::size_t>(k)], expected) << count << ' ' << k;
    }
  }
}

TEST_F(KernelVariants, RateCornersTheSame) {
  constexpr int kSpill = 16;
  const Plane image = pyramid_.level(0);
  std::vector<float> rows[2];
  std::vector<std::uint16_t> maxima[2];
  int k = 0;
  for (const Kernels* set : {&fast_, &plain_}) {
    std::vector<std::int32_t> xx(kWidth + 2 * kSpill);
    std::vector<std::int32_t> xy(xx.size());
    std::vector<std::int32_t> yy(xx.size());
    for (int y = 50; y < 55; ++y) {
      set->corner.accumulate_row(image, y, 1, xx.data() + kSpill, xy.data() + kSpill, yy.data() + kSpill);
    }
    rows[k].assign(xx.size(), 0.F);
    set->corner.eigenvalue_row(xx.data() + kSpill, xy.data() + kSpill, yy.data() + kSpill, 0, kWidth,
                               rows[k].data() + kSpill);
    const std::vector<float> nothing(xx.size());
    maxima[k].resize(kWidth);
    maxima[k].resize(static_cast<std::size_t>(set->corner.find_maxima(nothing.data() + kSpill, rows[k].data() + kSpill,
                                                                      nothing.data() + kSpill, 8, kWidth - 8, 1.F,
                                                                      maxima[k].data())));
    ++k;
  }
  for (std::size_t x = kSpill; x < kWidth + kSpill; ++x) {
    ASSERT_NEAR(rows[0][x], rows[1][x], 1e-2F + 1e-4F * rows[1][x]);
  }
  EXPECT_EQ(maxima[0], maxima[1]);
  EXPECT_FALSE(maxima[0].empty());
}

}  // namespace
}  // namespace kinetrace::features
