#include "kinetrace/trajectory/composition.hpp"

#include <random>

#include <Eigen/Cholesky>
#include <gtest/gtest.h>

namespace kinetrace::trajectory {
namespace {

constexpr int kTrials = 4000;

/// Draws left perturbations with a given covariance.
class PoseNoise {
 public:
  PoseNoise(const Matrix6d& covariance, unsigned seed) : root_(covariance.llt().matrixL()), random_(seed) {}
  Se3 operator()(const Se3& pose) {
    Vector6d xi;
    for (int i = 0; i < 6; ++i) {
      xi[i] = gauss_(random_);
    }
    return left_update(pose, root_ * xi);
  }

 private:
  Matrix6d root_;
  std::mt19937 random_;
  std::normal_distribution<double> gauss_;
};

Matrix6d some_covariance(double sigma_rad, double sigma_m) {
  Vector6d sigmas;
  sigmas << sigma_rad, 0.5 * sigma_rad, 2.0 * sigma_rad, sigma_m, 0.3 * sigma_m, 2.0 * sigma_m;
  Matrix6d mix = Matrix6d::Identity();
  mix(0, 1) = 0.4;
  mix(3, 5) = -0.5;
  mix(2, 4) = sigma_rad / sigma_m;
  const Matrix6d root = mix * sigmas.asDiagonal().toDenseMatrix();
  return root * root.transpose();
}

struct Poses {
  PoseWithCovariance T_world_cam{{so3_exp({0.1, 0.8, -0.2}), {20.0, -1.0, 45.0}}, some_covariance(0.001, 0.02)};
  PoseWithCovariance T_obj_cam{{so3_exp({-0.1, 2.0, 0.1}), {3.0, 0.5, -12.0}}, some_covariance(0.003, 0.04)};
};

TEST(Composition, IsEquationTwoForPosesAndPoints) {
  const Poses given;
  const Eigen::Vector3d p_obj(0.7, -0.4, 1.3);
  const Se3 T_world_obj = compose(given.T_world_cam, given.T_obj_cam).pose;
  const Eigen::Vector3d p_cam = given.T_obj_cam.pose.rotation.transpose() * (p_obj - given.T_obj_cam.pose.translation);
  const Eigen::Vector3d p_world = given.T_world_cam.pose.translation + given.T_world_cam.pose.rotation * p_cam;
  EXPECT_LT((object_point_in_world(given.T_world_cam.pose, given.T_obj_cam.pose, p_obj) - p_world).norm(), 1e-12);
  EXPECT_LT((T_world_obj * p_obj - p_world).norm(), 1e-12);
}

TEST(Composition, MovingTheWorldMovesThePathAndLeavesThePointCovarianceItsShape) {
  Poses given;
  const Se3 T_new_world{so3_exp({0.5, -1.0, 0.3}), {100.0, 20.0, -60.0}};
  const PoseWithCovariance before = compose(given.T_world_cam, given.T_obj_cam);
  const Matrix6d carry = adjoint(T_new_world);
  given.T_world_cam.pose = T_new_world * given.T_world_cam.pose;
  given.T_world_cam.covariance = carry * given.T_world_cam.covariance * carry.transpose();
  const PoseWithCovariance after = compose(given.T_world_cam, given.T_obj_cam);
  EXPECT_LT((after.pose.translation - T_new_world * before.pose.translation).norm(), 1e-10);
  EXPECT_LT((after.covariance - carry * before.covariance * carry.transpose()).norm(), 1e-9 * after.covariance.norm());
  const Eigen::Vector3d p_obj(1.0, 0.0, -2.0);
  const Eigen::Matrix3d turned =
      T_new_world.rotation * point_covariance(before, p_obj) * T_new_world.rotation.transpose();
  EXPECT_LT((point_covariance(after, p_obj) - turned).norm(), 1e-9 * after.covariance.norm());
}

TEST(Composition, CovarianceMatchesTheScatterOfPosesAndPoints) {
  const Poses given;
  const PoseWithCovariance composed = compose(given.T_world_cam, given.T_obj_cam);
  const Eigen::Vector3d p_obj(0.7, -0.4, 1.3);
  const Eigen::Vector3d p_world = composed.pose * p_obj;
  PoseNoise camera_noise(given.T_world_cam.covariance, 1);
  PoseNoise object_noise(given.T_obj_cam.covariance, 2);
  Matrix6d residual_sigma = Matrix6d::Zero();
  Eigen::Matrix3d point_residual_sigma = Eigen::Matrix3d::Zero();
  for (int i = 0; i < kTrials; ++i) {
    const Se3 pose = camera_noise(given.T_world_cam.pose) * object_noise(given.T_obj_cam.pose).inverse();
    const Vector6d error = left_difference(composed.pose, pose);
    residual_sigma += error * error.transpose() / kTrials;
    const Eigen::Vector3d point_error = pose * p_obj - p_world;
    point_residual_sigma += point_error * point_error.transpose() / kTrials;
  }
  EXPECT_LT((residual_sigma - composed.covariance).norm(), 0.08 * composed.covariance.norm());
  const Eigen::Matrix3d point = point_covariance(composed, p_obj);
  EXPECT_LT((point_residual_sigma - point).norm(), 0.08 * point.norm());
  for (int i = 0; i < 6; ++i) {
    EXPECT_NEAR(residual_sigma(i, i) / composed.covariance(i, i), 1.0, 0.12) << i;
  }
}

}  // namespace
}  // namespace kinetrace::trajectory
