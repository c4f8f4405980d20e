#include "dense_kernels.hpp"

#include <random>
#include <vector>

#include <gtest/gtest.h>

#include "kinetrace/core/arena.hpp"

namespace kinetrace::segmentation {
namespace {

constexpr int kWidth = 203;
constexpr int kHeight = 41;

/// Images whose rows may be read beyond their end.
class DenseKernelsTest : public ::testing::Test {
 protected:
  DenseKernelsTest() {
    std::mt19937 random(5);
    for (MutableGrayView* image : {&left_, &right_}) {
      *image = take_image<std::uint8_t>(arena_, kWidth, kHeight + 1);
      --image->height;
      for (int y = 0; y < kHeight; ++y) {
        for (int x = 0; x < kWidth; ++x) {
          image->row(y)[x] = static_cast<std::uint8_t>(65 + random() % 127);
        }
      }
    }
  }
  Arena arena_{1U << 20U};
  MutableGrayView left_;
  MutableGrayView right_;
};

struct Matches {
  std::vector<std::int16_t> costs = std::vector<std::int16_t>(static_cast<std::size_t>(kLevels) * kStride);
  std::vector<std::int16_t> best = std::vector<std::int16_t>(kStride);
  std::vector<std::int16_t> cost = std::vector<std::int16_t>(kStride);
  std::vector<std::int16_t> rival = std::vector<std::int16_t>(kStride);
  static constexpr int kLevels = 23;
  static constexpr int kPitch = 2;
  static constexpr int kOffset = -3;
  static constexpr int kCells = kWidth / kPitch + 1;
  static constexpr std::size_t kStride = 128;
};

Matches match(const DenseKernels& kernels, GrayView left, GrayView right) {
  Matches m;
  std::vector<std::int16_t> columns(kWidth + kMatchSpill);
  kernels.match_row(left, right, 7, Matches::kPitch, Matches::kOffset, Matches::kCells, Matches::kLevels,
                    columns.data(), m.costs.data(), static_cast<int>(Matches::kStride));
  kernels.choose_levels(m.costs.data(), Matches::kCells, Matches::kLevels, static_cast<int>(Matches::kStride),
                        m.best.data(), m.cost.data(), m.rival.data());
  return m;
}

TEST_F(DenseKernelsTest, CostsAreSumsOfAbsoluteDifferences) {
  const Matches m = match(baseline_dense_kernels(), left_, right_);
  for (int d = 0; d < Matches::kLevels; ++d) {
    for (int i = 0; i < Matches::kCells; ++i) {
      const int x0 = i * Matches::kPitch + Matches::kOffset;
      int expected = kNoCost;
      if (x0 >= d && x0 + kMatchWidth <= kWidth) {
        expected = 0;
        for (int y = 7; y < 7 + kMatchHeight; ++y) {
          for (int x = x0; x < x0 + kMatchWidth; ++x) {
            expected += std::abs(static_cast<int>(left_.row(y)[x]) - static_cast<int>(right_.row(y)[x - d]));
          }
        }
      }
      ASSERT_EQ(m.costs[static_cast<std::size_t>(d) * Matches::kStride + static_cast<std::size_t>(i)], expected)
          << "level " << d << " cell " << i;
    }
  }
}

TEST_F(DenseKernelsTest, TheBestLevelHasTheLeastCostAndItsRivalIsNoNeighbour) {
  const Matches m = match(baseline_dense_kernels(), left_, right_);
  for (std::size_t i = 0; i < static_cast<std::size_t>(Matches::kCells); ++i) {
    int best = 0;
    int rival = kNoCost;
    for (int d = 1; d < Matches::kLevels; ++d) {
      best = m.costs[static_cast<std::size_t>(d) * Matches::kStride + i] <
                     m.costs[static_cast<std::size_t>(best) * Matches::kStride + i]
                 ? d
                 : best;
    }
    for (int d = 0; d < Matches::kLevels; ++d) {
      rival = std::abs(d - best) > 1 ? std::min<int>(rival, m.costs[static_cast<std::size_t>(d) * Matches::kStride + i])
                                     : rival;
    }
    EXPECT_EQ(m.best[i], best);
    EXPECT_EQ(m.cost[i], m.costs[static_cast<std::size_t>(best) * Matches::kStride + i]);
    EXPECT_EQ(m.rival[i], rival);
  }
}

TEST_F(DenseKernelsTest, BothInstructionSetsAgree) {
  const DenseKernels& fast = dense_kernels();
  const DenseKernels& baseline = baseline_dense_kernels();
  const Matches a = match(fast, left_, right_);
  const Matches b = match(baseline, left_, right_);
  EXPECT_EQ(a.costs, b.costs);
  EXPECT_EQ(a.best, b.best);
  EXPECT_EQ(a.cost, b.cost);
  EXPECT_EQ(a.rival, b.rival);
  for (const float shift : {-3.3F, 0.F, 2.25F}) {
    EXPECT_EQ(fast.patch_difference(left_, 20, 15, right_, shift, 0.5F * shift),
              baseline.patch_difference(left_, 20, 15, right_, shift, 0.5F * shift));
  }
}

TEST_F(DenseKernelsTest, TheSumsOfAPatchFindASmallShift) {
  for (const DenseKernels* const kernels : {&dense_kernels(), &baseline_dense_kernels()}) {
    PatchSums s;
    ASSERT_TRUE(kernels->patch_sums(left_, 20, 15, left_, 0.F, 0.F, s));
    EXPECT_EQ(s.rr, 0.F);
    // Least squares for the way back, with the gradients there.
    ASSERT_TRUE(kernels->patch_sums(left_, 20, 15, left_, 0.2F, 0.1F, s));
    const float determinant = s.xx * s.yy - s.xy * s.xy;
    EXPECT_NEAR((s.yy * s.xr - s.xy * s.yr) / determinant, 0.2F, 0.05F);
    EXPECT_NEAR((s.xx * s.yr - s.xy * s.xr) / determinant, 0.1F, 0.05F);
    EXPECT_FALSE(kernels->patch_sums(left_, 20, 15, left_, -20.5F, 0.F, s));
  }
}

TEST_F(DenseKernelsTest, APatchDiffersFromItselfByNothingAndFromOutsideByNoNumber) {
  const DenseKernels& kernels = dense_kernels();
  EXPECT_EQ(kernels.patch_difference(left_, 20, 15, left_, 0.F, 0.F), 0.F);
  EXPECT_GT(kernels.patch_difference(left_, 20, 15, left_, 3.F, 0.F), 10.F);
  EXPECT_LT(kernels.patch_difference(left_, 20, 15, left_, -20.5F, 0.F), 0.F);
  EXPECT_LT(kernels.patch_difference(left_, 20, 15, left_, 0.F, 40.F), 0.F);
}

}  // namespace
}  // namespace kinetrace::segmentation
