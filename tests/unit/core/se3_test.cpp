#include "kinetrace/core/se3.hpp"

#include <numbers>
#include <random>

#include <gtest/gtest.h>

namespace kinetrace {
namespace {

constexpr double kPi = std::numbers::pi;

class Random {
 public:
  Eigen::Vector3d vector(double scale) { return scale * Eigen::Vector3d(next(), next(), next()); }
  Se3 pose() { return {so3_exp(vector(1.5)), vector(10.0)}; }

 private:
  double next() { return std::uniform_real_distribution<double>(-1.0, 1.0)(engine_); }
  std::mt19937 engine_{42};
};

double distance(const Se3& a, const Se3& b) {
  return (a.rotation - b.rotation).norm() + (a.translation - b.translation).norm();
}

TEST(So3, ExpGivesRotations) {
  Random random;
  for (const double scale : {0.0, 1e-9, 1e-5, 1e-4, 1e-3, 1.0, 3.0}) {
    const Eigen::Matrix3d r = so3_exp(random.vector(scale));
    EXPECT_LT((r * r.transpose() - Eigen::Matrix3d::Identity()).norm(), 1e-14);
    EXPECT_NEAR(r.determinant(), 1.0, 1e-14);
  }
}

TEST(So3, ExpTurnsByTheRightHandRule) {
  const Eigen::Vector3d turned = so3_exp({0.0, 0.0, kPi / 2.0}) * Eigen::Vector3d::UnitX();
  EXPECT_LT((turned - Eigen::Vector3d::UnitY()).norm(), 1e-15);
}

TEST(So3, LogIsTheInverseOfExpAtEveryAngle) {
  const Eigen::Vector3d axis = Eigen::Vector3d(1.0, -2.0, 0.5).normalized();
  for (const double angle : {0.0, 1e-13, 1e-8, 9.9e-5, 1.01e-4, 0.1, 1.0, 3.0, kPi - 1e-6, kPi - 1e-9}) {
    const Eigen::Vector3d omega = angle * axis;
    EXPECT_LT((so3_log(so3_exp(omega)) - omega).norm(), 1e-12 + 1e-8 * (angle > 3.1 ? 1.0 : 0.0)) << angle;
  }
}

TEST(So3, LogOfAHalfTurnHasNormPi) {
  EXPECT_NEAR(so3_log(so3_exp({kPi, 0.0, 0.0})).norm(), kPi, 1e-12);
}

TEST(So3, LogTakesTheShortWayRound) {
  EXPECT_LT((so3_log(so3_exp({0.0, 1.5 * kPi, 0.0})) - Eigen::Vector3d(0.0, -0.5 * kPi, 0.0)).norm(), 1e-12);
}

TEST(So3, OrthonormalisedBringsADriftedProductBack) {
  Random random;
  Eigen::Matrix3d r = so3_exp(random.vector(1.0));
  const Eigen::Matrix3d exact = r;
  r += 1e-4 * Eigen::Matrix3d::Random();
  const Eigen::Matrix3d back = orthonormalised(r);
  EXPECT_LT((back * back.transpose() - Eigen::Matrix3d::Identity()).norm(), 1e-14);
  EXPECT_LT((back - exact).norm(), 5e-4);
}

TEST(Se3, InverseAndProductCancel) {
  Random random;
  const Se3 a = random.pose();
  const Se3 b = random.pose();
  const Eigen::Vector3d p = random.vector(5.0);
  EXPECT_LT(distance(a * a.inverse(), Se3{}), 1e-13);
  EXPECT_LT(((a * b) * p - a * (b * p)).norm(), 1e-13);
}

TEST(Se3, LeftUpdateTurnsThePoseAboutTheOuterFramesOrigin) {
  Vector6d xi = Vector6d::Zero();
  xi[2] = kPi / 2.0;  // About z.
  xi[3] = 1.0;
  const Se3 moved = left_update({Eigen::Matrix3d::Identity(), {2.0, 0.0, 0.0}}, xi);
  EXPECT_LT((moved.translation - Eigen::Vector3d(1.0, 2.0, 0.0)).norm(), 1e-15);
}

TEST(Se3, LeftDifferenceUndoesLeftUpdate) {
  Random random;
  for (int i = 0; i < 20; ++i) {
    const Se3 a = random.pose();
    const Se3 b = random.pose();
    EXPECT_LT(distance(left_update(a, left_difference(a, b)), b), 1e-12);
  }
  EXPECT_LT(left_difference(Se3{}, Se3{}).norm(), 1e-15);
}

TEST(Se3, AdjointCarriesAPerturbationThroughAProduct) {
  Random random;
  const Se3 a = random.pose();
  const Se3 b = random.pose();
  const Matrix6d ad = adjoint(a);
  constexpr double kStep = 1e-6;
  for (int i = 0; i < 6; ++i) {
    Vector6d xi = Vector6d::Zero();
    xi[i] = kStep;
    const Vector6d numeric = left_difference(a * b, a * left_update(b, xi)) / kStep;
    // The left perturbation of A * B is that of A.
    EXPECT_LT((numeric - ad.col(i)).norm(), 1e-4) << "column " << i;
  }
}

TEST(Se3, CovarianceOfTheInverseFollowsTheAdjoint) {
  // A left perturbation xi of T is one of -adjoint(T^-1) xi of T^-1.
  Random random;
  const Se3 t = random.pose();
  constexpr double kStep = 1e-6;
  for (int i = 0; i < 6; ++i) {
    Vector6d xi = Vector6d::Zero();
    xi[i] = kStep;
    const Vector6d numeric = left_difference(t.inverse(), left_update(t, xi).inverse()) / kStep;
    EXPECT_LT((numeric + adjoint(t.inverse()).col(i)).norm(), 1e-4) << "column " << i;
  }
}

TEST(Se3, InterpolateMeetsBothEndsAndExtrapolates) {
  Random random;
  const Se3 a = random.pose();
  const Se3 step{so3_exp({0.0, 0.2, 0.1}), {1.0, 0.0, 2.0}};
  const Se3 b{a.rotation * step.rotation, a.translation + Eigen::Vector3d(1.0, 2.0, 3.0)};
  EXPECT_LT(distance(interpolate(a, b, 0.0), a), 1e-12);
  EXPECT_LT(distance(interpolate(a, b, 1.0), b), 1e-12);
  const Se3 beyond = interpolate(a, b, 2.0);
  EXPECT_LT((beyond.rotation - b.rotation * step.rotation).norm(), 1e-12);
  EXPECT_LT((beyond.translation - (a.translation + Eigen::Vector3d(2.0, 4.0, 6.0))).norm(), 1e-12);
}

TEST(Se3, PositionCovarianceDropsTheLeverArmToTheOrigin) {
  Random random;
  const Se3 t = random.pose();
  // Effect of a left perturbation on (rotation, position), numerically.
  constexpr double kStep = 1e-6;
  Matrix6d effect;
  for (int i = 0; i < 6; ++i) {
    Vector6d xi = Vector6d::Zero();
    xi[i] = kStep;
    const Se3 moved = left_update(t, xi);
    effect.col(i).head<3>() = so3_log(moved.rotation * t.rotation.transpose()) / kStep;
    effect.col(i).tail<3>() = (moved.translation - t.translation) / kStep;
  }
  // The left perturbation that turns about the body's own origin and moves it: an error of rotation and position alone.
  const Vector6d sigma = (Vector6d() << 0.1, 0.2, 0.3, 1.0, 2.0, 3.0).finished();
  const Matrix6d wanted = sigma.cwiseAbs2().asDiagonal();
  const Matrix6d left = effect.inverse() * wanted * effect.inverse().transpose();
  EXPECT_LT((rotation_position_covariance(t, left) - wanted).norm(), 1e-3);
}

TEST(Se3, NotFiniteIsSeen) {
  Se3 t;
  EXPECT_TRUE(t.is_finite());
  t.translation.y() = std::nan("");
  EXPECT_FALSE(t.is_finite());
}

}  // namespace
}  // namespace kinetrace
