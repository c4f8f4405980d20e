#include "kinetrace/trajectory/ground_plane.hpp"

#include <random>
#include <vector>

#include <gtest/gtest.h>

namespace kinetrace::trajectory {
namespace {

constexpr double kRad = 0.017453292519943295;

/// Points of a street in the frame of a camera that looks down by `pitch_rad` from `height_m`: ground, a wall, and
/// other objects.
std::vector<BodyPoint> street(double pitch_rad, double height_m, int on_ground, int on_wall, unsigned seed = 1) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> uniform(-1.0, 1.0);
  std::normal_distribution<double> bump(0.0, 0.02);
  const Eigen::Matrix3d R_cam_level = so3_exp({pitch_rad, 0.0, 0.0});
  std::vector<BodyPoint> points;
  const auto add = [&](const Eigen::Vector3d& level) {
    points.push_back({.position_m = (R_cam_level * level).cast<float>()});
  };
  for (int i = 0; i < on_ground; ++i) {
    add({8.0 * uniform(random), height_m + bump(random), 16.0 + 12.0 * uniform(random)});
  }
  for (int i = 0; i < on_wall; ++i) {
    add({8.0 + bump(random), height_m - 3.0 * (1.0 + uniform(random)), 16.0 + 12.0 * uniform(random)});
  }
  for (int i = 0; i < (on_ground + on_wall) / 4; ++i) {
    add({8.0 * uniform(random), height_m - 1.5 * (1.0 + uniform(random)), 16.0 + 12.0 * uniform(random)});
  }
  return points;
}

struct Estimator {
  Arena arena{std::size_t{1} << 16U};
  GroundEstimator ground{600, arena};
};

TEST(GroundEstimator, FindsTheStreetUnderCamerasThatLookAheadAndDown) {
  for (const double pitch_deg : {0.0, 5.0, -3.0, 43.0}) {
    Estimator estimator;
    const std::vector<BodyPoint> points = street(pitch_deg * kRad, 1.7, 120, 200);
    for (int frame = 0; frame < 5; ++frame) {
      estimator.ground.update(points, Se3{});
    }
    const Ground& ground = estimator.ground.ground();
    ASSERT_TRUE(ground.known) << pitch_deg;
    const Eigen::Vector3d down = so3_exp({pitch_deg * kRad, 0.0, 0.0}).col(1);
    EXPECT_GT(ground.down.dot(down), std::cos(0.5 * kRad)) << pitch_deg;
    EXPECT_NEAR(ground.height_m, 1.7, 0.05) << pitch_deg;
    EXPECT_LT(ground.sigma_m, 0.15);
  }
}

TEST(GroundEstimator, AWallIsNoGround) {
  Estimator estimator;
  std::vector<BodyPoint> wall;
  for (int i = 0; i < 200; ++i) {
    wall.push_back({.position_m = {0.1F * static_cast<float>(i % 20) - 1.F, 0.1F * static_cast<float>(i / 20), 8.F}});
  }
  for (int frame = 0; frame < 20; ++frame) {
    estimator.ground.update(wall, Se3{});
  }
  EXPECT_FALSE(estimator.ground.ground().known);
}

TEST(GroundEstimator, AFewPointsTellNothing) {
  Estimator estimator;
  estimator.ground.update(street(0.0, 1.7, 6, 0), Se3{});
  EXPECT_FALSE(estimator.ground.ground().known);
}

TEST(GroundEstimator, ItIsGivenInTheWorldWhereverTheCameraIs) {
  Estimator estimator;
  const Se3 T_world_cam{so3_exp({0.1, 0.7, -0.05}), {30.0, -2.0, 50.0}};
  std::vector<BodyPoint> points = street(0.0, 1.7, 150, 50);
  for (BodyPoint& point : points) {
    point.position_m = (T_world_cam * point.position_m.cast<double>().eval()).cast<float>();
  }
  for (int frame = 0; frame < 5; ++frame) {
    estimator.ground.update(points, T_world_cam);
  }
  const Ground& ground = estimator.ground.ground();
  ASSERT_TRUE(ground.known);
  EXPECT_GT(ground.down.dot(T_world_cam.rotation.col(1)), std::cos(0.5 * kRad));
  const Eigen::Vector3d below = T_world_cam * Eigen::Vector3d(0.0, 1.7, 0.0);
  EXPECT_NEAR(ground.down.dot(below) - ground.height_m, 0.0, 0.06);
  // In the camera's frame it is 1.7 m below again.
  EXPECT_NEAR(ground.in_frame(T_world_cam.inverse()).height_m, 1.7, 0.06);
  EXPECT_GT(ground.in_frame(T_world_cam.inverse()).down.y(), std::cos(0.5 * kRad));
}

TEST(GroundEstimator, SameInputSameGround) {
  Estimator a;
  Estimator b;
  const std::vector<BodyPoint> points = street(0.1, 1.7, 100, 100);
  for (int frame = 0; frame < 4; ++frame) {
    a.ground.update(points, Se3{});
    b.ground.update(points, Se3{});
  }
  EXPECT_EQ(a.ground.ground().down, b.ground.ground().down);
  EXPECT_EQ(a.ground.ground().height_m, b.ground.ground().height_m);
}

}  // namespace
}  // namespace kinetrace::trajectory
