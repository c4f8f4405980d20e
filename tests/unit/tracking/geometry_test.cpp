// Parts of mask prediction: similarity, disparity plane, reference mask.
#include <random>

#include <gtest/gtest.h>

#include "kinetrace/tracking/disparity_plane.hpp"
#include "kinetrace/tracking/label_overlap.hpp"
#include "kinetrace/tracking/reference_mask.hpp"
#include "kinetrace/tracking/similarity.hpp"

namespace kinetrace::tracking {
namespace {

constexpr Similarity kMotion{1.08, 0.05, -12.0, 7.0};

std::vector<PointPair> pairs_of(const Similarity& motion, int count, double noise_px, double outlier_ratio) {
  std::mt19937 random(5);
  std::uniform_real_distribution<double> place(0.0, 120.0);
  std::normal_distribution<double> noise(0.0, noise_px);
  std::vector<PointPair> pairs;
  for (int i = 0; i < count; ++i) {
    const Eigen::Vector2d from(300.0 + place(random), 150.0 + place(random));
    Eigen::Vector2d to = motion * from + Eigen::Vector2d(noise(random), noise(random));
    if (i < outlier_ratio * count) {
      to = Eigen::Vector2d(300.0 + place(random), 150.0 + place(random));
    }
    pairs.push_back({from.cast<float>(), to.cast<float>()});
  }
  return pairs;
}

TEST(Similarity, ComposesAndInverts) {
  const Eigen::Vector2d p(31.0, -4.0);
  const Similarity other{0.9, -0.2, 3.0, 1.0};
  EXPECT_LT(((kMotion * other) * p - kMotion * (other * p)).norm(), 1e-12);
  EXPECT_LT((kMotion.inverse() * (kMotion * p) - p).norm(), 1e-12);
  EXPECT_NEAR(kMotion.scale(), std::hypot(1.08, 0.05), 1e-15);
  EXPECT_LT(
      (Similarity::about({10.0, 20.0}, 2.0, {1.0, 1.0}) * Eigen::Vector2d(11.0, 20.0) - Eigen::Vector2d(13.0, 21.0))
          .norm(),
      1e-12);
}

TEST(FitSimilarity, FindsTheMotionAmongFortyPercentOutliers) {
  const auto pairs = pairs_of(kMotion, 50, 0.2, 0.4);
  const auto fitted = fit_similarity(pairs, {}, 1);
  ASSERT_TRUE(fitted.has_value());
  for (const Eigen::Vector2d& p : {Eigen::Vector2d(300, 150), Eigen::Vector2d(420, 270)}) {
    EXPECT_LT((*fitted * p - kMotion * p).norm(), 0.3);
  }
}

TEST(FitSimilarity, NeedsThreePointsThatAgree) {
  EXPECT_FALSE(fit_similarity({}, {}, 1).has_value());
  EXPECT_FALSE(fit_similarity(pairs_of(kMotion, 2, 0.0, 0.0), {}, 1).has_value());
  EXPECT_TRUE(fit_similarity(pairs_of(kMotion, 3, 0.0, 0.0), {}, 1).has_value());
  EXPECT_FALSE(fit_similarity(pairs_of(kMotion, 3, 0.0, 1.0), {}, 1).has_value());
}

TEST(FitSimilarity, RefusesPointsTooCloseTogetherForTheMask) {
  std::vector<PointPair> pairs;
  for (int i = 0; i < 4; ++i) {
    const int row = i / 2;
    const Eigen::Vector2f p(100.F + 3.F * static_cast<float>(i % 2), 100.F + 3.F * static_cast<float>(row));
    pairs.push_back({p, p + Eigen::Vector2f(0.2F * static_cast<float>(i % 2), 5.F)});
  }
  EXPECT_FALSE(fit_similarity(pairs, {.reach_px = 200.0}, 1).has_value());
}

TEST(FitSimilarity, RefusesAnImpossibleScale) {
  EXPECT_FALSE(fit_similarity(pairs_of({2.5, 0.0, 0.0, 0.0}, 20, 0.0, 0.0), {}, 1).has_value());
}

TEST(MedianTranslation, IgnoresAMinorityOfOutliers) {
  const std::vector<PointPair> pairs = pairs_of({1.0, 0.0, 9.0, -3.0}, 21, 0.0, 0.4);
  std::vector<float> scratch(pairs.size());
  EXPECT_LT((median_translation(pairs, scratch) - Eigen::Vector2d(9.0, -3.0)).norm(), 1.0);
}

TEST(DisparityPlane, IsUnknownWithoutSamples) {
  EXPECT_FALSE(fit_disparity({}, {}).known);
}

TEST(DisparityPlane, IsTheMedianOfFewSamples) {
  const std::array samples{DisparitySample{{0.F, 0.F}, 10.F}, DisparitySample{{5.F, 0.F}, 11.F},
                           DisparitySample{{9.F, 0.F}, 50.F}};
  std::array<float, 3> scratch{};
  const DisparityPlane plane = fit_disparity(samples, scratch);
  EXPECT_TRUE(plane.known);
  EXPECT_EQ(plane.mean_px, 11.F);
  EXPECT_EQ(plane.slope, Eigen::Vector2f::Zero());
}

TEST(DisparityPlane, FollowsATiltedSideDespiteOutliers) {
  std::mt19937 random(2);
  std::uniform_real_distribution<float> place(0.F, 200.F);
  std::vector<DisparitySample> samples;
  for (int i = 0; i < 60; ++i) {
    const Eigen::Vector2f p(place(random), place(random) * 0.5F);
    samples.push_back({p, i % 6 == 0 ? place(random) : 40.F + 0.04F * p.x() - 0.01F * p.y()});
  }
  std::vector<float> scratch(samples.size());
  const DisparityPlane plane = fit_disparity(samples, scratch);
  const auto at = [&](float x, float y) {
    return plane.mean_px + plane.slope.dot(Eigen::Vector2f(x, y) - plane.center_px);
  };
  EXPECT_NEAR(at(0.F, 0.F), 40.F, 0.5F);
  EXPECT_NEAR(at(200.F, 100.F), 47.F, 0.5F);
  EXPECT_LE(plane.max_px, 60.F);
}

class ReferenceMaskTest : public ::testing::Test {
 protected:
  static constexpr int kSide = 64;
  ReferenceMaskTest() : mask_(arena_, kSide, kSide) {}
  void capture_square(int x0, int y0, int size) {
    std::vector<std::uint8_t> pixels(std::size_t{kSide} * kSide);
    for (int y = y0; y < y0 + size; ++y) {
      std::fill_n(&pixels[static_cast<std::size_t>(y) * kSide + static_cast<std::size_t>(x0)], size, std::uint8_t{1});
    }
    mask_.capture({pixels.data(), kSide, kSide, kSide}, {0, 0, kSide, kSide},
                  [](std::uint8_t label, int, int) { return label == 1; });
  }
  [[nodiscard]] PixelBox drawn(int* area = nullptr) const {
    PixelBox box;
    mask_.for_each_pixel(mask_.current_box(), [&](int x, int y) {
      box.include(x, y);
      if (area != nullptr) {
        ++*area;
      }
    });
    return box;
  }
  Arena arena_{1U << 16U};
  ReferenceMask mask_;
};

TEST_F(ReferenceMaskTest, IsDrawnWhereItWasCaptured) {
  capture_square(13, 22, 9);
  int area = 0;
  const PixelBox box = drawn(&area);
  EXPECT_EQ(area, 81);
  EXPECT_EQ(box.x0, 13);
  EXPECT_EQ(box.y1, 31);
}

TEST_F(ReferenceMaskTest, MovesAndGrowsWithTheProductOfItsMotions) {
  capture_square(20, 20, 10);  // pixel centres 20..29, centre 24.5
  for (int i = 0; i < 10; ++i) {
    mask_.move(Similarity::about({24.5, 24.5}, std::pow(2.0, 0.1), {0.0, 0.0}));
  }
  mask_.move({1.0, 0.0, 5.0, 0.0});
  int area = 0;
  const PixelBox box = drawn(&area);
  EXPECT_EQ(area, 400);
  EXPECT_EQ(box.x0, 20);
  EXPECT_EQ(box.x1, 40);
}

TEST_F(ReferenceMaskTest, IsCutAtTheImageBorderAndComesBackWhole) {
  capture_square(0, 30, 10);
  mask_.move({1.0, 0.0, -6.0, 0.0});
  int area = 0;
  (void)drawn(&area);
  EXPECT_EQ(area, 40);
  mask_.move({1.0, 0.0, -1000.0, 0.0});
  EXPECT_TRUE(mask_.current_box().empty());
  mask_.move({1.0, 0.0, 1006.0, 0.0});
  area = 0;
  (void)drawn(&area);
  EXPECT_EQ(area, 100);
}

TEST_F(ReferenceMaskTest, IsEmptyBeforeAndAfterCapturingNothing) {
  EXPECT_TRUE(mask_.current_box().empty());
  capture_square(5, 5, 0);
  EXPECT_TRUE(mask_.current_box().empty());
}

TEST(Relabel, TranslatesEveryPixelOfAnyWidth) {
  LabelTable table{};
  table[3] = 7;
  table[255] = 255;
  for (const int width : {1, 7, 8, 9, 31}) {
    std::vector<std::uint8_t> source(static_cast<std::size_t>(width) * 2);
    source.back() = 3;
    source.front() = 255;
    std::vector<std::uint8_t> target(source.size(), 99);
    relabel({source.data(), width, 2, width}, table, {target.data(), width, 2, width});
    EXPECT_EQ(target.front(), 255);
    EXPECT_EQ(target.back(), 7);
    EXPECT_EQ(std::count(target.begin(), target.end(), 99), 0);
  }
}

TEST(IntersectionOverUnion, IsZeroForNothing) {
  EXPECT_EQ(intersection_over_union(0, 0, 0), 0.0);
  EXPECT_EQ(intersection_over_union(5, 5, 5), 1.0);
  EXPECT_DOUBLE_EQ(intersection_over_union(2, 6, 4), 0.25);
}

}  // namespace
}  // namespace kinetrace::tracking
