// Motion models and external measurements of a body, as costs on its poses.
#pragma once

#include <ceres/ceres.h>

#include "kinetrace/core/body_velocity.hpp"
#include "kinetrace/refinement/ceres_bundle_adjuster.hpp"
#include "pose_block.hpp"
#include "reprojection_jacobian.hpp"

namespace kinetrace::refinement {

/// Pose of the body in the world at one instant, from the camera's pose and a block T_cam_body.
struct WorldPose {
  Se3 T_world_cam;

  [[nodiscard]] Se3 of(const double* block) const { return T_world_cam * to_pose(block); }
  /// Derivative of (rotation about the world's axes, position) by the block's perturbation.
  [[nodiscard]] Matrix6d derivative(const double* block) const {
    const Eigen::Matrix3d& R = T_world_cam.rotation;
    Matrix6d by_block;
    by_block << R, Eigen::Matrix3d::Zero(), -R * skew(to_pose(block).translation), R;
    return by_block;
  }
};

/// Change of velocity, in the body's own axes, between successive intervals, weighted by MotionPrior::root_information.
class SteadyCost final : public ceres::SizedCostFunction<6, kPoseAmbient, kPoseAmbient, kPoseAmbient> {
 public:
  SteadyCost(const std::array<WorldPose, 3>& poses, double before_s, double after_s, const Matrix6d& root_information)
      : poses_(poses), before_s_(before_s), after_s_(after_s), root_information_(root_information) {}

  bool Evaluate(double const* const* blocks, double* residuals, double** jacobians) const override {
    const Se3 a = poses_[0].of(blocks[0]);
    const Se3 b = poses_[1].of(blocks[1]);
    const Se3 c = poses_[2].of(blocks[2]);
    const BodyVelocity before = body_velocity(a, b, before_s_);
    const BodyVelocity after = body_velocity(b, c, after_s_);
    Eigen::Map<Vector6d>(residuals, 6) = root_information_ * (after.value - before.value);
    const std::array<Matrix6d, 3> by_pose = {-before.by_from, after.by_from - before.by_to, after.by_to};
    for (std::size_t i = 0; jacobians != nullptr && i < by_pose.size(); ++i) {
      put_derivative<6>(root_information_ * by_pose[i] * poses_[i].derivative(blocks[i]), jacobians[i]);
    }
    return true;
  }

 private:
  std::array<WorldPose, 3> poses_;
  double before_s_;
  double after_s_;
  Matrix6d root_information_;
};

/// Velocity of a body at rest, or turn rate of one that does not turn, with standard deviation `sigma`.
class VelocityCost final : public ceres::SizedCostFunction<6, kPoseAmbient, kPoseAmbient> {
 public:
  VelocityCost(const std::array<WorldPose, 2>& poses, double interval_s, const Vector6d& inverse_sigma)
      : poses_(poses), interval_s_(interval_s), inverse_sigma_(inverse_sigma) {}

  bool Evaluate(double const* const* blocks, double* residuals, double** jacobians) const override {
    const BodyVelocity velocity = body_velocity(poses_[0].of(blocks[0]), poses_[1].of(blocks[1]), interval_s_);
    Eigen::Map<Vector6d>(residuals, 6) = inverse_sigma_.cwiseProduct(velocity.value);
    const std::array<Matrix6d, 2> by_pose = {velocity.by_from, velocity.by_to};
    for (std::size_t i = 0; jacobians != nullptr && i < by_pose.size(); ++i) {
      put_derivative<6>(inverse_sigma_.asDiagonal() * by_pose[i] * poses_[i].derivative(blocks[i]), jacobians[i]);
    }
    return true;
  }

 private:
  std::array<WorldPose, 2> poses_;
  double interval_s_;
  Vector6d inverse_sigma_;
};

/// External measurement of the body's pose in the world.
class PoseCost final : public ceres::SizedCostFunction<6, kPoseAmbient> {
 public:
  PoseCost(const WorldPose& pose, const Se3& T_world_body, const Vector6d& inverse_sigma)
      : pose_(pose), measured_(T_world_body), inverse_sigma_(inverse_sigma) {}

  bool Evaluate(double const* const* blocks, double* residuals, double** jacobians) const override {
    const Se3 at = pose_.of(blocks[0]);
    Vector6d error;
    error << so3_log(at.rotation * measured_.rotation.transpose()), at.translation - measured_.translation;
    Eigen::Map<Vector6d>(residuals, 6) = inverse_sigma_.cwiseProduct(error);
    if (jacobians != nullptr) {
      put_derivative<6>(inverse_sigma_.asDiagonal() * pose_.derivative(blocks[0]), jacobians[0]);
    }
    return true;
  }

 private:
  WorldPose pose_;
  Se3 measured_;
  Vector6d inverse_sigma_;
};

/// External measurement of one frame's camera pose relative to another one's. Blocks: both frames, and the ratio of
/// true to measured distance.
class StepCost final : public ceres::SizedCostFunction<6, kPoseAmbient, kPoseAmbient, 1> {
 public:
  explicit StepCost(const BatchStep& step) : step_(step) {}

  bool Evaluate(double const* const* blocks, double* residuals, double** jacobians) const override {
    const Se3 T_from_to = to_pose(blocks[0]) * to_pose(blocks[1]).inverse();
    const Eigen::Matrix3d& R = step_.T_from_to.rotation;
    const Se3 measured{R, blocks[2][0] * step_.T_from_to.translation};
    Eigen::Map<Vector6d>(residuals, 6) = step_.root_information * left_difference(measured, T_from_to);
    if (jacobians != nullptr) {
      put_derivative<6>(step_.root_information, jacobians[0]);
      put_derivative<6>(-step_.root_information * adjoint(T_from_to), jacobians[1]);
    }
    if (jacobians != nullptr && jacobians[2] != nullptr) {
      Vector6d by_scale = Vector6d::Zero();
      by_scale.tail<3>() = -(T_from_to.rotation * R.transpose() * step_.T_from_to.translation);
      Eigen::Map<Vector6d>(jacobians[2], 6) = step_.root_information * by_scale;
    }
    return true;
  }

 private:
  BatchStep step_;
};

/// Prior of the scale about 1.
class ScaleCost final : public ceres::SizedCostFunction<1, 1> {
 public:
  explicit ScaleCost(double sigma) : sigma_(sigma) {}

  bool Evaluate(double const* const* blocks, double* residuals, double** jacobians) const override {
    residuals[0] = (blocks[0][0] - 1.0) / sigma_;
    if (jacobians != nullptr && jacobians[0] != nullptr) {
      jacobians[0][0] = 1.0 / sigma_;
    }
    return true;
  }

 private:
  double sigma_;
};

/// External position fix of the camera's path on a map. Blocks: map, frame before, frame after.
class FixCost final : public ceres::SizedCostFunction<3, kPoseAmbient, kPoseAmbient, kPoseAmbient> {
 public:
  explicit FixCost(const BatchFix& fix) : fix_(fix) {}

  bool Evaluate(double const* const* blocks, double* residuals, double** jacobians) const override {
    const Se3 T_map_body = to_pose(blocks[0]);
    const Se3 T_before_body = to_pose(blocks[1]);
    const Se3 T_after_body = to_pose(blocks[2]);
    const Eigen::Vector3d antenna_body_m = (1.0 - fix_.part) * (T_before_body.inverse() * fix_.antenna_m) +
                                           fix_.part * (T_after_body.inverse() * fix_.antenna_m);
    const Eigen::Vector3d antenna_map_m = T_map_body * antenna_body_m;
    Eigen::Map<Eigen::Vector3d>(residuals, 3) = fix_.inverse_sigma.cwiseProduct(antenna_map_m - fix_.position_m);
    if (jacobians != nullptr) {
      const auto weight = fix_.inverse_sigma.asDiagonal();
      put_derivative<3>(weight * pose_jacobian(antenna_map_m), jacobians[0]);
      const auto by_frame = [&](double part, const Se3& T_cam_body) -> Eigen::Matrix<double, 3, 6> {
        return -part * (weight * T_map_body.rotation * T_cam_body.rotation.transpose() * pose_jacobian(fix_.antenna_m));
      };
      put_derivative<3>(by_frame(1.0 - fix_.part, T_before_body), jacobians[1]);
      put_derivative<3>(by_frame(fix_.part, T_after_body), jacobians[2]);
    }
    return true;
  }

 private:
  BatchFix fix_;
};

}  // namespace kinetrace::refinement
