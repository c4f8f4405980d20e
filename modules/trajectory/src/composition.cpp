#include "kinetrace/trajectory/composition.hpp"

namespace kinetrace::trajectory {

PoseWithCovariance compose(const PoseWithCovariance& T_world_cam, const PoseWithCovariance& T_obj_cam) {
  PoseWithCovariance T_world_obj;
  T_world_obj.pose = T_world_cam.pose * T_obj_cam.pose.inverse();
  // With errors a of T_world_cam and b of T_obj_cam:
  // Exp(a) T_world_cam (Exp(b) T_obj_cam)^-1 = Exp(a) Exp(-Ad(T_world_obj) b) T_world_obj.
  const Matrix6d carry = adjoint(T_world_obj.pose);
  T_world_obj.covariance = T_world_cam.covariance + carry * T_obj_cam.covariance * carry.transpose();
  return T_world_obj;
}

Eigen::Matrix3d point_covariance(const PoseWithCovariance& T_world_obj, const Eigen::Vector3d& p_obj) {
  Eigen::Matrix<double, 3, 6> jacobian;
  jacobian << -skew(T_world_obj.pose * p_obj), Eigen::Matrix3d::Identity();
  return jacobian * T_world_obj.covariance * jacobian.transpose();
}

Eigen::Vector3d object_point_in_world(const Se3& T_world_cam, const Se3& T_obj_cam, const Eigen::Vector3d& p_obj) {
  const Eigen::Vector3d p_cam = T_obj_cam.inverse() * p_obj;
  return T_world_cam * p_cam;
}

}  // namespace kinetrace::trajectory
