#include "kinetrace/core/box3.hpp"

#include <cmath>

#include <Eigen/Geometry>

namespace kinetrace {

// Not inline: Eigen's rotation between two directions (a singular value decomposition for opposite ones) costs seconds
// of compile time in every file.
Eigen::Matrix3d upright_axes(const Eigen::Vector3d& down, double yaw_rad) {
  const double c = std::cos(yaw_rad);
  const double s = std::sin(yaw_rad);
  Eigen::Matrix3d turn;
  turn << c, 0.0, s, 0.0, 1.0, 0.0, -s, 0.0, c;
  return Eigen::Quaterniond::FromTwoVectors(Eigen::Vector3d::UnitY(), down).toRotationMatrix() * turn;
}

double upright_yaw(const Eigen::Vector3d& down, const Eigen::Vector3d& direction) {
  const Eigen::Vector3d level =
      Eigen::Quaterniond::FromTwoVectors(down, Eigen::Vector3d::UnitY()).toRotationMatrix() * direction;
  return std::atan2(-level.z(), level.x());
}

}  // namespace kinetrace
