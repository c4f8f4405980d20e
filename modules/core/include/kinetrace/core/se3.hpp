// Rigid-body transforms. Poses are written T_a_b: p_a = T_a_b * p_b, so that inner letters cancel.
#pragma once

#include <cmath>

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "kinetrace/core/export.hpp"

namespace kinetrace {

using Vector6d = Eigen::Matrix<double, 6, 1>;
using Matrix6d = Eigen::Matrix<double, 6, 6>;

/// The cross-product matrix: skew(a) * b = a x b.
[[nodiscard]] inline Eigen::Matrix3d skew(const Eigen::Vector3d& a) {
  Eigen::Matrix3d m;
  m << 0, -a.z(), a.y(), a.z(), 0, -a.x(), -a.y(), a.x(), 0;
  return m;
}

/// Rotation of `omega.norm()` radians about `omega` (Rodrigues' formula).
[[nodiscard]] KINETRACE_API Eigen::Matrix3d so3_exp(const Eigen::Vector3d& omega_rad);
/// Inverse of so3_exp; the result's norm is in [0, pi].
[[nodiscard]] KINETRACE_API Eigen::Vector3d so3_log(const Eigen::Matrix3d& rotation);
/// The rotation nearest to `matrix`. Products of rotations drift off SO(3); call this once a frame.
[[nodiscard]] KINETRACE_API Eigen::Matrix3d orthonormalised(const Eigen::Matrix3d& matrix);

/// A rigid transform: rotation, then translation in metres.
struct Se3 {
  Eigen::Matrix3d rotation = Eigen::Matrix3d::Identity();
  Eigen::Vector3d translation = Eigen::Vector3d::Zero();

  [[nodiscard]] Eigen::Vector3d operator*(const Eigen::Vector3d& p) const { return rotation * p + translation; }
  [[nodiscard]] Se3 operator*(const Se3& other) const {
    return {rotation * other.rotation, rotation * other.translation + translation};
  }
  [[nodiscard]] Se3 inverse() const { return {rotation.transpose(), -(rotation.transpose() * translation)}; }
  [[nodiscard]] Se3 orthonormalised() const { return {kinetrace::orthonormalised(rotation), translation}; }
  [[nodiscard]] Eigen::Quaterniond quaternion() const { return Eigen::Quaterniond(rotation).normalized(); }
  [[nodiscard]] bool is_finite() const { return rotation.allFinite() && translation.allFinite(); }
};

/// Applies Exp(xi) on the left, with xi = (rotation in rad, translation in m) and the two parts decoupled: R' =
/// so3_exp(xi_r) * R, t' = so3_exp(xi_r) * t + xi_t. This is the one perturbation model of the project: Jacobians and
/// covariances of T_a_b are with respect to xi in frame a.
[[nodiscard]] KINETRACE_API Se3 left_update(const Se3& pose, const Vector6d& xi);
/// The xi with left_update(from, xi) == to.
[[nodiscard]] KINETRACE_API Vector6d left_difference(const Se3& from, const Se3& to);
/// Constant-velocity interpolation, s in [0, 1]; extrapolates beyond.
[[nodiscard]] KINETRACE_API Se3 interpolate(const Se3& a, const Se3& b, double s);
/// The matrix Ad with left_update(A, Ad * xi) * B == A * left_update(B, xi) to first order: transforms a covariance of
/// B into the frame of A * B.
[[nodiscard]] KINETRACE_API Matrix6d adjoint(const Se3& a);

/// Covariance of (rotation about the axes of frame a, position of b's origin in a) from one of the left perturbation.
/// The two differ by the lever arm to a's origin; outputs use this one.
[[nodiscard]] KINETRACE_API Matrix6d rotation_position_covariance(const Se3& T_a_b, const Matrix6d& left_covariance);

}  // namespace kinetrace
