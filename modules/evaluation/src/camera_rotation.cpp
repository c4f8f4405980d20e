#include "kinetrace/evaluation/camera_rotation.hpp"

#include <Eigen/SVD>

namespace kinetrace::evaluation {

Eigen::Matrix3d camera_rotation(std::span<const PosePair> pairs) {
  constexpr std::size_t kFrames = 10;
  Eigen::Matrix3d correlation = Eigen::Matrix3d::Zero();
  for (std::size_t i = kFrames; i < pairs.size(); ++i) {
    const PosePair& a = pairs[i - kFrames];
    const PosePair& b = pairs[i];
    const Se3 true_motion = a.T_world_cam_true.inverse() * b.T_world_cam_true;
    const Se3 motion = a.T_world_cam.inverse() * b.T_world_cam;
    // A rotation by one radian counts as much as a displacement of one metre; R rotates both.
    correlation += motion.translation * true_motion.translation.transpose() +
                   so3_log(motion.rotation) * so3_log(true_motion.rotation).transpose();
  }
  const Eigen::JacobiSVD<Eigen::Matrix3d> svd(correlation, Eigen::ComputeFullU | Eigen::ComputeFullV);
  constexpr double kMinRatio = 1e-6;
  const Eigen::Vector3d& strengths = svd.singularValues();
  if (!(strengths[1] > kMinRatio * strengths[0])) {
    return Eigen::Matrix3d::Identity();
  }
  const double sign = (svd.matrixU() * svd.matrixV().transpose()).determinant() < 0.0 ? -1.0 : 1.0;
  return svd.matrixU() * Eigen::Vector3d(1.0, 1.0, sign).asDiagonal() * svd.matrixV().transpose();
}

}  // namespace kinetrace::evaluation
