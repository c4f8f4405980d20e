#include "kinetrace/core/se3.hpp"

namespace kinetrace {

Eigen::Matrix3d so3_exp(const Eigen::Vector3d& omega_rad) {
  const double theta_sq = omega_rad.squaredNorm();
  const double theta = std::sqrt(theta_sq);
  // Below 1e-4 rad the series is exact to double precision.
  const double a = theta < 1e-4 ? 1.0 - theta_sq / 6.0 : std::sin(theta) / theta;
  const double b = theta < 1e-4 ? 0.5 - theta_sq / 24.0 : (1.0 - std::cos(theta)) / theta_sq;
  const Eigen::Matrix3d w = skew(omega_rad);
  return Eigen::Matrix3d::Identity() + a * w + b * w * w;
}

Eigen::Vector3d so3_log(const Eigen::Matrix3d& rotation) {
  Eigen::Quaterniond q(rotation);
  q.normalize();
  if (q.w() < 0.0) {
    q.coeffs() = -q.coeffs();
  }
  const double n = q.vec().norm();
  // 2 * atan2(n, w) stays accurate near pi, where acos of the trace does not.
  const double scale = n < 1e-12 ? 2.0 : 2.0 * std::atan2(n, q.w()) / n;
  return scale * q.vec();
}

Eigen::Matrix3d orthonormalised(const Eigen::Matrix3d& matrix) {
  return Eigen::Quaterniond(matrix).normalized().toRotationMatrix();
}

Se3 left_update(const Se3& pose, const Vector6d& xi) {
  const Eigen::Matrix3d delta = so3_exp(xi.head<3>());
  return {delta * pose.rotation, delta * pose.translation + xi.tail<3>()};
}

Vector6d left_difference(const Se3& from, const Se3& to) {
  const Se3 delta = to * from.inverse();
  Vector6d xi;
  xi << so3_log(delta.rotation), delta.translation;
  return xi;
}

Se3 interpolate(const Se3& a, const Se3& b, double s) {
  return {a.rotation * so3_exp(s * so3_log(a.rotation.transpose() * b.rotation)),
          (1.0 - s) * a.translation + s * b.translation};
}

Matrix6d adjoint(const Se3& a) {
  Matrix6d ad = Matrix6d::Zero();
  ad.topLeftCorner<3, 3>() = a.rotation;
  ad.bottomLeftCorner<3, 3>() = skew(a.translation) * a.rotation;
  ad.bottomRightCorner<3, 3>() = a.rotation;
  return ad;
}

Matrix6d rotation_position_covariance(const Se3& T_a_b, const Matrix6d& left_covariance) {
  Matrix6d to_position = Matrix6d::Identity();
  to_position.bottomLeftCorner<3, 3>() = -skew(T_a_b.translation);
  return to_position * left_covariance * to_position.transpose();
}

}  // namespace kinetrace
