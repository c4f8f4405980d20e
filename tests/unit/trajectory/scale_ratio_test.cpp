#include "kinetrace/trajectory/scale_ratio.hpp"

#include <array>
#include <cmath>
#include <random>
#include <vector>

#include <gtest/gtest.h>

#include "kinetrace/trajectory/composition.hpp"

namespace kinetrace::trajectory {
namespace {

ScaleRatio estimate(const std::vector<double>& object, const std::vector<double>& background) {
  std::vector<double> scratch(object.size());
  return estimate_scale_ratio(object, background, scratch);
}

TEST(ScaleRatio, IsOneWithoutUsableFrames) {
  const double nan = std::nan("");
  EXPECT_EQ(estimate({}, {}).ratio, 1.0);
  const ScaleRatio none = estimate({0.0, -1.0, nan, 2.0}, {1.0, 1.0, 1.0, nan});
  EXPECT_EQ(none.ratio, 1.0);
  EXPECT_EQ(none.frames, 0U);
}

TEST(ScaleRatio, OneFrameIsTaken) {
  const ScaleRatio scale = estimate({0.25}, {0.5});
  EXPECT_EQ(scale.ratio, 2.0);
  EXPECT_EQ(scale.frames, 1U);
}

TEST(ScaleRatio, ResistsOutliersAndSkipsFramesWithoutPose) {
  std::mt19937 random(4);
  std::normal_distribution<double> gauss;
  std::vector<double> object;
  std::vector<double> background;
  for (int i = 0; i < 100; ++i) {
    object.push_back(0.8 * (1.0 + 0.02 * gauss(random)));
    background.push_back(i % 4 == 0 ? 30.0 : 2.4);
    if (i % 10 == 1) {
      object.back() = std::nan("");
    }
  }
  const ScaleRatio scale = estimate(object, background);
  EXPECT_EQ(scale.frames, 90U);
  EXPECT_NEAR(scale.ratio, 3.0, 0.05);
  EXPECT_LT(scale.sigma, 0.03);
  EXPECT_GT(scale.sigma, 0.003);
}

TEST(ScaleRatio, AppliedItMakesEquationTwoConsistent) {
  // The object's reconstruction has its own unit, 2.5 times the background's.
  const ScaleRatio scale = estimate({0.2}, {0.5});
  const Se3 T_world_cam{so3_exp({0.0, 0.3, 0.0}), {1.0, 0.0, 4.0}};
  const Se3 T_obj_cam{so3_exp({0.0, -0.5, 0.1}), {2.0, 0.3, -9.0}};
  const Eigen::Vector3d p_obj(0.5, 0.1, 0.7);
  const Se3 T_unscaled{T_obj_cam.rotation, T_obj_cam.translation / 2.5};
  const Eigen::Vector3d p_world =
      object_point_in_world(T_world_cam, scaled(T_unscaled, scale), scaled(Eigen::Vector3d(p_obj / 2.5), scale));
  EXPECT_LT((p_world - object_point_in_world(T_world_cam, T_obj_cam, p_obj)).norm(), 1e-12);
}

}  // namespace
}  // namespace kinetrace::trajectory
