#include "velocity_test.hpp"

#include <random>

#include <gtest/gtest.h>

namespace kinetrace::segmentation {
namespace {

TEST(DistanceToBall, IsZeroInsideAndMahalanobisForAPoint) {
  const Eigen::Matrix3f c = Eigen::Vector3f(0.1F, 0.2F, 4.F).asDiagonal();
  EXPECT_EQ(distance_to_ball_sq({0.1F, 0.F, 0.F}, c, 0.2F), 0.F);
  EXPECT_NEAR(distance_to_ball_sq({1.F, 2.F, 3.F}, c, 1e-6F), mahalanobis_sq({1.F, 2.F, 3.F}, c), 0.05F);
}

TEST(DistanceToBall, AgreesWithASearchOverTheBall) {
  std::mt19937 random(3);
  std::normal_distribution<float> normal;
  for (int round = 0; round < 50; ++round) {
    Eigen::Matrix3f a;
    Eigen::Vector3f v;
    for (int i = 0; i < 3; ++i) {
      v[i] = 2.F * normal(random);
      for (int j = 0; j < 3; ++j) {
        a(i, j) = normal(random);
      }
    }
    const Eigen::Matrix3f c = a * a.transpose() + 0.05F * Eigen::Matrix3f::Identity();
    const float radius = 0.5F;
    float least = v.norm() <= radius ? 0.F : 1e9F;
    for (int k = 0; k < 20000 && least > 0.F; ++k) {
      const Eigen::Vector3f u = radius * Eigen::Vector3f(normal(random), normal(random), normal(random)).normalized();
      least = std::min(least, mahalanobis_sq(v - u, c));
    }
    EXPECT_NEAR(distance_to_ball_sq(v, c, radius), least, 0.02F * least + 0.02F);
  }
}

TEST(DistanceToBall, LooksAcrossWhatIsUncertain) {
  // 1 m/s sideways with a sigma of .05, 5 m/s in depth with a sigma of 5: the speed is uncertain, the motion is not.
  const Eigen::Matrix3f c = Eigen::Vector3f(0.0025F, 0.0025F, 25.F).asDiagonal();
  EXPECT_GT(distance_to_ball_sq({1.F, 0.F, 5.F}, c, 0.25F), 200.F);
  EXPECT_LT(distance_to_ball_sq({0.2F, 0.F, 5.F}, c, 0.25F), 2.F);
}

}  // namespace
}  // namespace kinetrace::segmentation
