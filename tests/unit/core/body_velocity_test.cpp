#include "kinetrace/core/body_velocity.hpp"

#include <optional>

#include <Eigen/LU>
#include <gtest/gtest.h>

namespace kinetrace {
namespace {

constexpr MotionPrior kPrior{3.0, 1.0, 0.6, 0.2, 0.5};
const Eigen::Vector3d kVertical = Eigen::Vector3d(1.0, 2.0, 2.0) / 3.0;
const Eigen::Vector3d kAlong = Eigen::Vector3d(2.0, 1.0, -2.0) / 3.0;

TEST(MotionPrior, HoldsAlongTheGroundAndAlongItsNormal) {
  const Eigen::Matrix3d acceleration = kPrior.acceleration_covariance(kVertical);
  EXPECT_NEAR(kVertical.dot(acceleration * kVertical), 1.0, 1e-12);
  EXPECT_NEAR(kAlong.dot(acceleration * kAlong), 9.0, 1e-12);
  EXPECT_NEAR(kAlong.dot(acceleration * kVertical), 0.0, 1e-12);
  const Eigen::Matrix3d turn = kPrior.turn_covariance(kVertical);
  EXPECT_NEAR(kVertical.dot(turn * kVertical), 0.36, 1e-12);
  EXPECT_NEAR(kAlong.dot(turn * kAlong), 0.04, 1e-12);
}

TEST(MotionPrior, VelocitiesLieAlongTheGround) {
  const Eigen::Matrix3d covariance = kPrior.velocity_covariance(kVertical, 20.0);
  EXPECT_NEAR(kVertical.dot(covariance * kVertical), 0.25, 1e-12);
  EXPECT_NEAR(kAlong.dot(covariance * kAlong), 400.0, 1e-9);
  EXPECT_EQ(kPrior.velocity_covariance(std::nullopt, 20.0), Eigen::Matrix3d(400.0 * Eigen::Matrix3d::Identity()));
  const Eigen::Matrix3d root = kPrior.velocity_root_information(kVertical, 20.0);
  EXPECT_LT((root.transpose() * root * covariance - Eigen::Matrix3d::Identity()).norm(), 1e-9);
}

TEST(MotionPrior, IsTheSameInAllDirectionsWhereTheGroundIsNotKnown) {
  EXPECT_EQ(kPrior.acceleration_covariance(std::nullopt), Eigen::Matrix3d(9.0 * Eigen::Matrix3d::Identity()));
  EXPECT_EQ(kPrior.turn_covariance(std::nullopt), Eigen::Matrix3d(0.36 * Eigen::Matrix3d::Identity()));
}

TEST(MotionPrior, RootInformationIsThatOfTheCovarianceOverTheSpan) {
  for (const std::optional<Eigen::Vector3d>& vertical : {std::optional(kVertical), std::optional<Eigen::Vector3d>()}) {
    constexpr double kSpan_s = 0.4;
    Matrix6d covariance = Matrix6d::Zero();
    covariance.topLeftCorner<3, 3>() = kAccelerationTime_s * kSpan_s * kPrior.turn_covariance(vertical);
    covariance.bottomRightCorner<3, 3>() = kAccelerationTime_s * kSpan_s * kPrior.acceleration_covariance(vertical);
    const Eigen::Matrix3d R_world_body = so3_exp({0.2, -0.5, 0.1});
    Matrix6d to_world = Matrix6d::Zero();
    to_world.topLeftCorner<3, 3>() = to_world.bottomRightCorner<3, 3>() = R_world_body;
    const Matrix6d root = kPrior.root_information(vertical, R_world_body, kSpan_s) * to_world.transpose();
    EXPECT_LT((root.transpose() * root * covariance - Matrix6d::Identity()).norm(), 1e-9);
  }
}

}  // namespace
}  // namespace kinetrace
