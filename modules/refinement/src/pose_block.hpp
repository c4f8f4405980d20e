// Poses as parameter blocks of Ceres.
#pragma once

#include <array>

#include <Eigen/Core>
#include <ceres/manifold.h>

#include "kinetrace/core/se3.hpp"

namespace kinetrace::refinement {

inline constexpr int kPoseAmbient = 12;  // Rotation matrix by columns, then translation.
inline constexpr int kPoseTangent = 6;
using PoseBlock = std::array<double, kPoseAmbient>;
template <int kRows>
using PoseDerivative = Eigen::Matrix<double, kRows, kPoseAmbient, Eigen::RowMajor>;

inline Se3 to_pose(const double* block) {
  return {Eigen::Map<const Eigen::Matrix3d>(block), Eigen::Map<const Eigen::Vector3d>(block + 9)};
}

inline void from_pose(const Se3& pose, double* block) {
  Eigen::Map<Eigen::Matrix3d>(block, 3, 3) = pose.rotation;
  Eigen::Map<Eigen::Vector3d>(block + 9, 3) = pose.translation;
}

/// Writes a derivative by the perturbation where Ceres expects the one by the block; see LeftPerturbation. `jacobian`
/// may be null.
template <int kRows>
void put_derivative(const Eigen::Matrix<double, kRows, kPoseTangent>& derivative, double* jacobian) {
  if (jacobian != nullptr) {
    Eigen::Map<PoseDerivative<kRows>> pose(jacobian);
    pose.setZero();
    pose.template leftCols<kPoseTangent>() = derivative;
  }
}

/// T_cam_body under the project's left perturbation. Cost functions write derivatives with respect to the perturbation
/// into the first six columns, so that the plus-Jacobian is simply [ I ; 0 ].
class LeftPerturbation final : public ceres::Manifold {
 public:
  int AmbientSize() const override { return kPoseAmbient; }
  int TangentSize() const override { return kPoseTangent; }
  bool Plus(const double* x, const double* delta, double* x_plus_delta) const override {
    from_pose(left_update(to_pose(x), Vector6d(delta)).orthonormalised(), x_plus_delta);
    return true;
  }
  bool PlusJacobian(const double* /*x*/, double* jacobian) const override {
    Eigen::Map<Eigen::Matrix<double, kPoseAmbient, kPoseTangent, Eigen::RowMajor>>(jacobian).setIdentity();
    return true;
  }
  bool Minus(const double* y, const double* x, double* y_minus_x) const override {
    Eigen::Map<Vector6d>(y_minus_x, kPoseTangent) = left_difference(to_pose(x), to_pose(y));
    return true;
  }
  bool MinusJacobian(const double* /*x*/, double* jacobian) const override {
    Eigen::Map<Eigen::Matrix<double, kPoseTangent, kPoseAmbient, Eigen::RowMajor>>(jacobian).setIdentity();
    return true;
  }
};

}  // namespace kinetrace::refinement
