#include "kinetrace/sfm/noise_scale.hpp"

#include <random>
#include <vector>

#include <gtest/gtest.h>

namespace kinetrace::sfm {
namespace {

std::vector<float> squared_residuals(std::size_t count, double sigma_px, double outlier_share, unsigned seed) {
  std::mt19937 engine(seed);
  std::normal_distribution<double> unit;
  std::uniform_real_distribution<double> chance;
  std::vector<float> squared;
  for (std::size_t i = 0; i < count; ++i) {
    const double sigma = chance(engine) < outlier_share ? 20.0 * sigma_px : sigma_px;
    double sum = 0.0;
    for (int k = 0; k < 3; ++k) {
      const double r = sigma * unit(engine);
      sum += r * r;
    }
    squared.push_back(static_cast<float>(sum));
  }
  return squared;
}

double learnt_px(std::size_t count, double sigma_px, double outlier_share) {
  NoiseScale noise(0.05, 0.4);
  for (unsigned frame = 0; frame < 40; ++frame) {
    std::vector<float> squared = squared_residuals(count, sigma_px, outlier_share, frame);
    noise.learn(squared);
  }
  return noise.sigma_px();
}

TEST(NoiseScale, StartsAtTheMost) {
  EXPECT_EQ(NoiseScale(0.05, 0.4).sigma_px(), 0.4);
}

TEST(NoiseScale, FindsTheScatterOfManyResiduals) {
  for (const double sigma_px : {0.1, 0.2, 0.3}) {
    EXPECT_NEAR(learnt_px(300, sigma_px, 0.0), sigma_px, 0.05 * sigma_px);
  }
}

TEST(NoiseScale, IsLittleMovedByOutliers) {
  EXPECT_NEAR(learnt_px(300, 0.1, 0.2), 0.1, 0.025);
}

TEST(NoiseScale, StaysWithinItsBounds) {
  EXPECT_EQ(learnt_px(100, 0.001, 0.0), 0.05);
  EXPECT_EQ(learnt_px(100, 3.0, 0.0), 0.4);
}

TEST(NoiseScale, LearnsNothingFromAlmostNothing) {
  NoiseScale noise(0.05, 0.4);
  std::vector<float> none;
  noise.learn(none);
  std::vector<float> three(3, 1e-4F);
  noise.learn(three);
  EXPECT_EQ(noise.sigma_px(), 0.4);
}

TEST(NoiseScale, FewResidualsMoveItLessThanMany) {
  NoiseScale few(0.05, 0.4);
  NoiseScale many(0.05, 0.4);
  std::vector<float> five = squared_residuals(5, 0.1, 0.0, 1);
  std::vector<float> hundreds = squared_residuals(500, 0.1, 0.0, 1);
  few.learn(five);
  many.learn(hundreds);
  EXPECT_GT(few.sigma_px(), many.sigma_px());
}

TEST(NoiseScale, ForgetsOnRestart) {
  NoiseScale noise(0.05, 0.4);
  std::vector<float> squared = squared_residuals(100, 0.1, 0.0, 1);
  noise.learn(squared);
  EXPECT_LT(noise.sigma_px(), 0.4);
  noise.restart();
  EXPECT_EQ(noise.sigma_px(), 0.4);
}

}  // namespace
}  // namespace kinetrace::sfm
