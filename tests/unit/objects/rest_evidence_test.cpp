#include "kinetrace/objects/rest_evidence.hpp"

#include <gtest/gtest.h>

namespace kinetrace::objects {
namespace {

Eigen::Matrix3d sure_to(double sigma_mps) {
  return sigma_mps * sigma_mps * Eigen::Matrix3d::Identity();
}

TEST(MovingEvidence, NothingMeasuredSaysNothing) {
  EXPECT_NEAR(moving_evidence(Eigen::Vector3d::Zero(), sure_to(1000.0)), 0.0, 0.01);
  EXPECT_NEAR(moving_evidence({20.0, 0.0, 0.0}, sure_to(1000.0)), 0.0, 0.01);
}

TEST(MovingEvidence, GrowsWithSpeedAndItsSureness) {
  EXPECT_LT(moving_evidence({0.05, 0.0, 0.0}, sure_to(0.1)), -3.0) << "parked";
  EXPECT_GT(moving_evidence({1.0, 0.0, 0.0}, sure_to(0.2)), 3.0) << "a walker";
  EXPECT_GT(moving_evidence({0.0, 0.0, 10.0}, sure_to(1.0)), 10.0) << "a car";
  double before = moving_evidence(Eigen::Vector3d::Zero(), sure_to(0.3));
  for (double speed_mps = 0.3; speed_mps < 3.0; speed_mps += 0.3) {
    const double now = moving_evidence({0.0, 0.0, speed_mps}, sure_to(0.3));
    EXPECT_GT(now, before) << speed_mps;
    before = now;
  }
}

TEST(MovingEvidence, IsUndecidedWhereRestIsUnlikelyButNotRuledOut) {
  EXPECT_NEAR(moving_evidence({0.0, 0.0, -6.0}, sure_to(2.3)), 0.0, 1.0);
}

TEST(MovingEvidence, ASureMotionAcrossIsNotDrownedByAnUncertainDepth) {
  Eigen::Matrix3d covariance = sure_to(0.1);
  covariance(2, 2) = 25.0;
  EXPECT_GT(moving_evidence({1.0, 0.0, 3.0}, covariance), 5.0);
}

}  // namespace
}  // namespace kinetrace::objects
