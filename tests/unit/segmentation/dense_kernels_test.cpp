#include "dense_kernels.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
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
  explicit Matches(int cell_pitch)
      : pitch(cell_pitch), cells(kWidth / cell_pitch + 1), pair_costs{costs, costs, costs} {}
  int pitch;
  int cells;
  std::vector<std::int16_t> costs = std::vector<std::int16_t>(static_cast<std::size_t>(kLevels) * kStride);
  std::array<std::vector<std::int16_t>, 3> pair_costs;
  std::vector<std::int16_t> best = std::vector<std::int16_t>(kStride);
  std::vector<std::int16_t> cost = std::vector<std::int16_t>(kStride);
  std::vector<std::int16_t> second_cost = std::vector<std::int16_t>(kStride);
  static constexpr int kLevels = 23;
  static constexpr int kOffset = -3;
  static constexpr std::size_t kStride = 128;
  [[nodiscard]] std::int16_t at(int level, int cell) const {
    return costs[static_cast<std::size_t>(level) * kStride + static_cast<std::size_t>(cell)];
  }
};

Matches match(const DenseKernels& kernels, GrayView left, GrayView right, int pitch) {
  Matches m(pitch);
  std::vector<std::int16_t> scratch(kWidth / 2 + kMatchSpill);
  std::array<const std::int16_t*, 3> pairs{};
  for (std::size_t k = 0; k < pairs.size(); ++k) {
    m.pair_costs[k].resize(m.costs.size() + kMatchSpill);
    kernels.match_row_pair(left, right, 7 + kMatchedRows * static_cast<int>(k), pitch, Matches::kOffset, m.cells,
                           Matches::kLevels, scratch.data(), m.pair_costs[k].data(),
                           static_cast<int>(Matches::kStride));
    pairs[k] = m.pair_costs[k].data();
  }
  kernels.choose_levels(pairs.data(), m.cells, Matches::kLevels, static_cast<int>(Matches::kStride), m.costs.data(),
                        m.best.data(), m.cost.data(), m.second_cost.data());
  return m;
}

TEST_F(DenseKernelsTest, CostsAreSumsOfAbsoluteDifferences) {
  for (const int pitch : {2, 4}) {
    const Matches m = match(baseline_dense_kernels(), left_, right_, pitch);
    for (int d = 0; d < Matches::kLevels; ++d) {
      for (int i = 0; i < m.cells; ++i) {
        const int x0 = i * pitch + Matches::kOffset;
        int expected = kNoCost;
        if (x0 >= d && x0 + kMatchWidth <= kWidth) {
          expected = 0;
          for (int y = 7; y < 7 + kMatchHeight; ++y) {
            for (int x = x0; x < x0 + kMatchWidth; ++x) {
              expected += std::abs(static_cast<int>(left_.row(y)[x]) - static_cast<int>(right_.row(y)[x - d]));
            }
          }
        }
        ASSERT_EQ(m.at(d, i), expected) << "pitch " << pitch << " level " << d << " cell " << i;
      }
    }
  }
}

TEST_F(DenseKernelsTest, TheBestLevelHasTheLeastCostAndTheSecondIsNoNeighbour) {
  const Matches m = match(baseline_dense_kernels(), left_, right_, 2);
  for (int i = 0; i < m.cells; ++i) {
    int best = 0;
    int second_cost = kNoCost;
    for (int d = 1; d < Matches::kLevels; ++d) {
      best = m.at(d, i) < m.at(best, i) ? d : best;
    }
    for (int d = 0; d < Matches::kLevels; ++d) {
      second_cost = std::abs(d - best) > 1 ? std::min<int>(second_cost, m.at(d, i)) : second_cost;
    }
    const auto k = static_cast<std::size_t>(i);
    EXPECT_EQ(m.best[k], best);
    EXPECT_EQ(m.cost[k], m.at(best, i));
    EXPECT_EQ(m.second_cost[k], second_cost);
  }
}

TEST_F(DenseKernelsTest, BothInstructionSetsAgree) {
  const DenseKernels& fast = dense_kernels();
  const DenseKernels& baseline = baseline_dense_kernels();
  const Matches a = match(fast, left_, right_, 2);
  const Matches b = match(baseline, left_, right_, 2);
  for (int i = 0; i < a.cells; ++i) {
    const auto k = static_cast<std::size_t>(i);
    EXPECT_EQ(a.best[k], b.best[k]);
    EXPECT_EQ(a.cost[k], b.cost[k]);
    EXPECT_EQ(a.second_cost[k], b.second_cost[k]);
    for (int d = 0; d < Matches::kLevels; ++d) {
      EXPECT_EQ(a.at(d, i), b.at(d, i));
    }
  }
  for (const float shift : {-3.3F, 0.F, 2.25F}) {
    EXPECT_EQ(fast.patch_difference(left_, 20, 15, right_, shift, 0.5F * shift),
              baseline.patch_difference(left_, 20, 15, right_, shift, 0.5F * shift));
  }
}

TEST_F(DenseKernelsTest, APatchDiffersByTheMeanOfItsPixelsDifferences) {
  struct Shift {
    double x;
    double y;
    double tolerance_grey;  // Weights are multiples of 1/32.
  };
  for (const Shift& shift : {Shift{2.25, -1.5, 1e-4}, Shift{2.0 + 5.0 / 32.0, -2.0 + 27.0 / 32.0, 0.05}}) {
    const double right = shift.x - 2.0;
    const double below = shift.y + 2.0;
    double total = 0.0;
    for (int y = 15; y < 15 + kPatchPx; ++y) {
      for (int x = 20; x < 20 + kPatchPx; ++x) {
        const auto at = [&](int dx, int dy) { return static_cast<double>(right_.row(y - 2 + dy)[x + 2 + dx]); };
        const double value = (1.0 - below) * ((1.0 - right) * at(0, 0) + right * at(1, 0)) +
                             below * ((1.0 - right) * at(0, 1) + right * at(1, 1));
        total += std::abs(static_cast<double>(left_.row(y)[x]) - value);
      }
    }
    for (const DenseKernels* const kernels : {&dense_kernels(), &baseline_dense_kernels()}) {
      EXPECT_NEAR(
          kernels->patch_difference(left_, 20, 15, right_, static_cast<float>(shift.x), static_cast<float>(shift.y)),
          total / (kPatchPx * kPatchPx), shift.tolerance_grey);
    }
  }
}

TEST_F(DenseKernelsTest, APlanesScoreCountsWhatLiesOnItLessWhatLiesBeyond) {
  std::vector<float> u_px;
  std::vector<float> v_px;
  std::vector<float> disparity_px;
  const std::array<float, 3> plane{0.01F, 0.1F, 3.F};
  int expected = 0;
  for (int i = 0; i < 19; ++i) {
    u_px.push_back(static_cast<float>(7 * i));
    v_px.push_back(static_cast<float>(40 - i));
    constexpr std::array<float, 4> kOff_px{0.5F, -0.5F, 2.F, -4.F};
    constexpr std::array<int, 4> kScores{1, 1, 0, -1};
    const auto kind = static_cast<std::size_t>(i % 4);
    disparity_px.push_back(plane[0] * u_px.back() + plane[1] * v_px.back() + plane[2] + kOff_px[kind]);
    expected += kScores[kind];
  }
  for (const DenseKernels* const kernels : {&dense_kernels(), &baseline_dense_kernels()}) {
    EXPECT_EQ(kernels->plane_score({u_px.data(), v_px.data(), disparity_px.data(), 19}, plane.data(), 1.F), expected);
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
