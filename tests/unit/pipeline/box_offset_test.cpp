#include "box_offset.hpp"

#include <numbers>

#include <gtest/gtest.h>

namespace kinetrace::pipeline {
namespace {

using Eigen::Vector3d;

/// Four metres long, along -z.
const Box3 kCar{.center_m = {1.0, 0.0, 20.0}, .size_m = {4.0, 1.5, 1.8}, .yaw_rad = 0.5 * std::numbers::pi};

TEST(OutsideOf, IsNothingAnywhereInTheBox) {
  for (const double along : {-1.9, 0.0, 1.9}) {
    EXPECT_TRUE(outside_of(kCar, kCar.center_m + Vector3d(0.8, -0.7, along)).isZero(1e-12)) << along;
  }
}

TEST(OutsideOf, IsTheWayFromTheNearestSide) {
  EXPECT_TRUE(outside_of(kCar, kCar.center_m + Vector3d(0.0, 0.0, 5.0)).isApprox(Vector3d(0.0, 0.0, 3.0), 1e-12));
  EXPECT_TRUE(outside_of(kCar, kCar.center_m + Vector3d(-1.9, 0.2, 0.0)).isApprox(Vector3d(-1.0, 0.0, 0.0), 1e-12));
  EXPECT_TRUE(outside_of(kCar, kCar.center_m + Vector3d(1.9, 0.75, -3.0)).isApprox(Vector3d(1.0, 0.0, -1.0), 1e-12));
}

TEST(OutsideOf, TurnsWithTheBox) {
  Box3 across = kCar;
  across.yaw_rad = 0.0;
  const Vector3d point_m = kCar.center_m + Vector3d(0.0, 0.0, 1.9);
  EXPECT_TRUE(outside_of(kCar, point_m).isZero(1e-12));
  EXPECT_TRUE(outside_of(across, point_m).isApprox(Vector3d(0.0, 0.0, 1.0), 1e-12));
}

}  // namespace
}  // namespace kinetrace::pipeline
