#include "kinetrace/core/box3.hpp"

#include <numbers>

#include <gtest/gtest.h>

namespace kinetrace {
namespace {

using Eigen::Vector3d;

TEST(Box3, CornersAreThoseOfTheYaw) {
  const Box3 box{{1.0, 2.0, 3.0}, {4.0, 1.0, 2.0}, 0.0};
  for (const Vector3d& corner : box.corners()) {
    EXPECT_NEAR(std::abs(corner.x() - 1.0), 2.0, 1e-12);
    EXPECT_NEAR(std::abs(corner.y() - 2.0), 0.5, 1e-12);
    EXPECT_NEAR(std::abs(corner.z() - 3.0), 1.0, 1e-12);
  }
  // Turned by a right angle about y, the length lies along -z: so does the corner at its end, bottom, left.
  Box3 turned = box;
  turned.yaw_rad = 0.5 * std::numbers::pi;
  EXPECT_TRUE(turned.corners()[7].isApprox(Vector3d(2.0, 2.5, 1.0), 1e-12)) << turned.corners()[7];
}

TEST(Box3, StandsAlongDown) {
  const Vector3d down = Vector3d(0.2, 0.9, -0.4).normalized();
  for (const double yaw_rad : {-2.5, 0.0, 1.0}) {
    const Box3 box{{0.0, 0.0, 5.0}, {4.0, 1.5, 1.8}, yaw_rad, down};
    const Eigen::Matrix3d axes = box.rotation();
    EXPECT_TRUE(axes.col(1).isApprox(down, 1e-12));
    EXPECT_NEAR(axes.determinant(), 1.0, 1e-12);
    EXPECT_NEAR(upright_yaw(down, axes.col(0)), yaw_rad, 1e-12);
    // A vertical component does not change the yaw.
    EXPECT_NEAR(upright_yaw(down, axes.col(0) + 0.7 * down), yaw_rad, 1e-12);
  }
}

}  // namespace
}  // namespace kinetrace
