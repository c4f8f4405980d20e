// Costs of the formulations that the batch solver lacks.
#pragma once

#include <array>
#include <cstddef>
#include <vector>

#include <ceres/ceres.h>

#include "motion_costs.hpp"
#include "pose_block.hpp"
#include "reprojection_jacobian.hpp"

namespace kinetrace::refinement {

using PointDerivative = Eigen::Map<Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>;

/// Stereo reprojection of a point through a chain of poses: p_cam = T_first block_1 ... block_n p.
class ChainCost final : public ceres::CostFunction {
 public:
  ChainCost(const StereoGeometry& geometry, const BundleObservation& seen, const Se3& T_first, std::size_t poses)
      : geometry_(&geometry), seen_(seen), T_first_(T_first) {
    set_num_residuals(3);
    mutable_parameter_block_sizes()->assign(poses, kPoseAmbient);
    mutable_parameter_block_sizes()->push_back(3);
  }

  /// The last block is the point.
  bool Evaluate(double const* const* blocks, double* residuals, double** jacobians) const override {
    const std::size_t poses = parameter_block_sizes().size() - 1;
    std::vector<Eigen::Vector3d> moved(poses + 1, Eigen::Map<const Eigen::Vector3d>(blocks[poses]));
    for (std::size_t i = poses; i-- > 0;) {
      moved[i] = to_pose(blocks[i]) * moved[i + 1];
    }
    const auto r = reprojection_jacobian(*geometry_, seen_, T_first_ * moved.front());
    Eigen::Map<Eigen::Vector3d>(residuals, 3) = r.residual;
    Eigen::Matrix3d by_moved = r.d_point * T_first_.rotation;
    for (std::size_t i = 0; jacobians != nullptr && i < poses; ++i) {
      put_derivative<3>(by_moved * pose_jacobian(moved[i]), jacobians[i]);
      by_moved *= to_pose(blocks[i]).rotation;
    }
    if (jacobians != nullptr && jacobians[poses] != nullptr) {
      PointDerivative(jacobians[poses], 3, 3) = by_moved;
    }
    return true;
  }

 private:
  const StereoGeometry* geometry_;
  BundleObservation seen_;
  Se3 T_first_;
};

/// A world point moves with its object between two frames (Zhang et al., VDO-SLAM, 2020). Blocks: T_cam_obj of both
/// frames, the point in both. Residual: the distance to H p, in the object frame, where it has the same length.
class MovedPointCost final : public ceres::SizedCostFunction<3, kPoseAmbient, kPoseAmbient, 3, 3> {
 public:
  MovedPointCost(const std::array<Se3, 2>& T_world_cam, double sigma_m)
      : T_world_cam_(T_world_cam), inverse_sigma_(1.0 / sigma_m) {}

  bool Evaluate(double const* const* blocks, double* residuals, double** jacobians) const override {
    Eigen::Map<Eigen::Vector3d> residual(residuals);
    residual.setZero();
    for (std::size_t i = 0; i < 2; ++i) {
      const double weight = i == 0 ? -inverse_sigma_ : inverse_sigma_;
      const Se3 T_cam_world = T_world_cam_[i].inverse();
      const Se3 T_cam_obj = to_pose(blocks[i]);
      const Eigen::Vector3d p_cam = T_cam_world * Eigen::Map<const Eigen::Vector3d>(blocks[2 + i]);
      const Eigen::Matrix3d by_p_cam = weight * T_cam_obj.rotation.transpose();
      residual += weight * (T_cam_obj.inverse() * p_cam);
      if (jacobians != nullptr) {
        put_derivative<3>(-by_p_cam * pose_jacobian(p_cam), jacobians[i]);
        if (jacobians[2 + i] != nullptr) {
          PointDerivative(jacobians[2 + i], 3, 3) = by_p_cam * T_cam_world.rotation;
        }
      }
    }
    return true;
  }

 private:
  std::array<Se3, 2> T_world_cam_;
  double inverse_sigma_;
};

/// SteadyCost for two motions in the object frame, from each frame to the next.
class SteadyMotionCost final : public ceres::SizedCostFunction<6, kPoseAmbient, kPoseAmbient> {
 public:
  SteadyMotionCost(const std::array<double, 2>& intervals_s, const Vector6d& inverse_sigma)
      : intervals_s_(intervals_s), inverse_sigma_(inverse_sigma) {}

  bool Evaluate(double const* const* blocks, double* residuals, double** jacobians) const override {
    Eigen::Map<Vector6d> residual(residuals);
    residual.setZero();
    for (std::size_t i = 0; i < 2; ++i) {
      const BodyVelocity velocity = body_velocity({}, to_pose(blocks[i]), intervals_s_[i]);
      const Vector6d weight = i == 0 ? Vector6d(-inverse_sigma_) : inverse_sigma_;
      residual += weight.cwiseProduct(velocity.value);
      if (jacobians != nullptr) {
        put_derivative<6>(weight.asDiagonal() * velocity.by_to * WorldPose{}.derivative(blocks[i]), jacobians[i]);
      }
    }
    return true;
  }

 private:
  std::array<double, 2> intervals_s_;
  Vector6d inverse_sigma_;
};

}  // namespace kinetrace::refinement
