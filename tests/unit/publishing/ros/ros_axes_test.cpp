#include "ros/ros_axes.hpp"

#include <numbers>

#include <gtest/gtest.h>

namespace kinetrace::publishing {
namespace {

TEST(RosAxes, AheadIsXLeftIsYUpIsZ) {
  EXPECT_EQ(ros_axes() * Eigen::Vector3d(0, 0, 1), Eigen::Vector3d(1, 0, 0));
  EXPECT_EQ(ros_axes() * Eigen::Vector3d(-1, 0, 0), Eigen::Vector3d(0, 1, 0));
  EXPECT_EQ(ros_axes() * Eigen::Vector3d(0, -1, 0), Eigen::Vector3d(0, 0, 1));
  EXPECT_DOUBLE_EQ(ros_axes().determinant(), 1.0);
}

TEST(RosAxes, ComposingAndChangingAxesCommute) {
  const Se3 A{so3_exp({0.1, 0.2, -0.3}), {1, 2, 3}};
  const Se3 B{so3_exp({-0.4, 0.1, 0.2}), {-1, 0, 2}};
  const Se3 expected = to_ros(A * B);
  const Se3 composed = to_ros(A) * to_ros(B);
  EXPECT_TRUE(composed.rotation.isApprox(expected.rotation, 1e-12));
  EXPECT_TRUE(composed.translation.isApprox(expected.translation, 1e-12));
}

TEST(RosAxes, CovarianceFollowsTheErrorsItIsOf) {
  // Covariance of the outer product of one error is the outer product of that error in ROS's axes and order.
  Vector6d error;
  error << 0.1, 0.2, 0.3, 1.0, 2.0, 3.0;
  Vector6d expected;
  expected << ros_axes() * error.tail<3>(), ros_axes() * error.head<3>();
  EXPECT_TRUE(to_ros_covariance(error * error.transpose()).isApprox(expected * expected.transpose(), 1e-12));
}

TEST(RosAxes, BoxesPointWhereTheyPointed) {
  for (const double yaw_rad : {-3.0, -1.2, 0.0, 0.7, 2.5}) {
    const RosBox box = to_ros(Box3{{1, 2, 3}, {4.0, 1.5, 1.8}, yaw_rad});
    const Eigen::Vector3d along(std::cos(yaw_rad), 0.0, -std::sin(yaw_rad));  // Box3, our axes.
    EXPECT_TRUE((box.T_odom_box.rotation.col(0)).isApprox(ros_axes() * along, 1e-12)) << yaw_rad;
    EXPECT_TRUE((box.T_odom_box.rotation.col(2)).isApprox(Eigen::Vector3d::UnitZ(), 1e-12));
    EXPECT_EQ(box.T_odom_box.translation, Eigen::Vector3d(3, -1, -2));
    EXPECT_EQ(box.size_m, Eigen::Vector3d(4.0, 1.8, 1.5));
  }
}

TEST(RosAxes, ATiltedBoxIsTilted) {
  const Eigen::Vector3d down = Eigen::Vector3d(0.0, 0.8, -0.6);  // The ground in the frame of a camera that looks down.
  const Box3 box{{1, 2, 3}, {4.0, 1.5, 1.8}, 0.7, down};
  const RosBox seen = to_ros(box);
  EXPECT_TRUE(seen.T_odom_box.rotation.col(2).isApprox(ros_axes() * -down, 1e-12));
  EXPECT_NEAR(seen.T_odom_box.rotation.determinant(), 1.0, 1e-12);
}

TEST(RosAxes, AnUnknownFrontIsTheVarianceOfHalfTurns) {
  const RosBox box = to_ros(Box3{{1, 2, 3}, {4.0, 1.5, 1.8}, 0.7});
  EXPECT_NEAR(to_ros_covariance(box, {{1, 1, 1}, {1, 1, 1}, 0.1, true})(5, 5), 0.01, 1e-12);
  EXPECT_GT(to_ros_covariance(box, {{1, 1, 1}, {1, 1, 1}, 0.1, false})(5, 5), 4.0);
}

}  // namespace
}  // namespace kinetrace::publishing
