#include "box_extent.hpp"

#include <cmath>

#include <gtest/gtest.h>

namespace kinetrace::pipeline {
namespace {

constexpr StereoGeometry kGeometry{.fx_px = 700.0,
                                   .fy_px = 700.0,
                                   .cx_px = 600.0,
                                   .cy_px = 200.0,
                                   .baseline_m = 0.5,
                                   .width_px = 1200,
                                   .height_px = 400};
/// Outline against box: a twentieth of the largest dimension, 4 m.
constexpr double kOutline_m = 0.2;

Box3 car_at(const Eigen::Vector3d& center_m, double yaw_rad = 0.0) {
  return {.center_m = center_m, .size_m = {4.0, 1.5, 2.0}, .yaw_rad = yaw_rad};
}

tracking::ImageExtent extent_of(const Box3& box, const Box3Sigma& sigma = {},
                                const Eigen::Matrix3d& position_covariance = Eigen::Matrix3d::Zero(),
                                const Se3& T_world_cam = {}) {
  return image_extent(box, sigma, position_covariance, T_world_cam, kGeometry).value();
}

TEST(BoxExtent, IsBoundedByTheNearestCorners) {
  const tracking::ImageExtent extent = extent_of(car_at({1.0, 0.5, 11.0}));
  // The near face is 10 m away; sides lie half a pixel beyond the centres of the outermost pixels.
  EXPECT_NEAR(extent.low_px.x(), 600.5 - 70.0, 1e-9);
  EXPECT_NEAR(extent.high_px.x(), 600.5 + 210.0, 1e-9);
  EXPECT_NEAR(extent.low_px.y(), 200.5 - 17.5, 1e-9);
  EXPECT_NEAR(extent.high_px.y(), 200.5 + 87.5, 1e-9);
}

TEST(BoxExtent, FollowsTheCamera) {
  Se3 T_world_cam;
  T_world_cam.translation = {1.0, 0.0, 1.0};
  const tracking::ImageExtent moved = extent_of(car_at({2.0, 0.5, 12.0}), {}, Eigen::Matrix3d::Zero(), T_world_cam);
  const tracking::ImageExtent same = extent_of(car_at({1.0, 0.5, 11.0}));
  EXPECT_LT((moved.low_px - same.low_px).norm() + (moved.high_px - same.high_px).norm(), 1e-9);
}

TEST(BoxExtent, SidesAreAsUncertainAsTheCornersThatBoundThem) {
  const double outline_px = 70.0 * kOutline_m;  // 70 pixels a metre
  EXPECT_NEAR(extent_of(car_at({0.0, 0.0, 11.0})).low_sigma_px.y(), outline_px, 0.05 * outline_px)
      << "the depth of an edge near the axis hardly matters";
  Eigen::Matrix3d down_only = Eigen::Matrix3d::Zero();
  down_only(1, 1) = 0.3 * 0.3;
  EXPECT_NEAR(extent_of(car_at({0.0, 0.0, 11.0}), {}, down_only).high_sigma_px.y(), std::hypot(70.0 * 0.3, outline_px),
              1.0);
  const Box3Sigma long_or_short{.center_m = {0.5, 0.0, 0.0}, .size_m = {1.0, 0.0, 0.0}};
  const tracking::ImageExtent across = extent_of(car_at({0.0, 0.0, 11.0}), long_or_short);
  EXPECT_NEAR(across.high_sigma_px.x(), 70.0 * std::sqrt(0.5 * 0.5 + 0.25 + kOutline_m * kOutline_m), 2.0);
  EXPECT_LT(across.high_sigma_px.y(), 1.1 * outline_px);
}

TEST(BoxExtent, OfACarBesideTheCameraIsWhatLiesInFront) {
  // Along the viewing direction, 3 m to the left, from 2 m behind the camera to 2 m in front of it.
  const tracking::ImageExtent extent = extent_of(car_at({-3.0, 0.5, 0.0}, std::acos(0.0)));
  EXPECT_LT(extent.low_px.x(), -10000.0) << "beyond the left border";
  EXPECT_NEAR(extent.high_px.x(), 600.5 - 700.0 * 2.0 / 2.0, 1e-6) << "its right side, 2 m away, 2 m to the left";
  EXPECT_NEAR(extent.high_sigma_px.x(), 350.0 * std::hypot(kOutline_m, kOutline_m), 1.0);
}

TEST(BoxExtent, OfACarBehindTheCameraIsNotKnown) {
  EXPECT_FALSE(image_extent(car_at({0.0, 0.5, -10.0}), {}, Eigen::Matrix3d::Zero(), {}, kGeometry));
}

TEST(BoxVolume, HoldsThePointsOfTheBoxAndNoOthers) {
  Se3 T_world_cam;
  T_world_cam.rotation = so3_exp({0.05, -0.3, 0.02});
  T_world_cam.translation = {1.0, -0.5, 2.0};
  const Box3 box = car_at({-1.0, 0.5, 13.0}, 0.7);
  const Box3Sigma sigma{.center_m = {0.1, 0.1, 0.1}, .size_m = {0.0, 0.0, 0.0}};
  const tracking::PredictedVolume volume = volume_of(box, sigma, Eigen::Matrix3d::Zero(), T_world_cam, kGeometry);
  const auto density_at = [&](const Eigen::Vector3d& in_box_m) {
    const Eigen::Vector3d p_cam = T_world_cam.inverse() * (box.center_m + box.rotation() * in_box_m);
    const Eigen::Vector3d uvr_px = kGeometry.project(p_cam);
    return volume.density_at(uvr_px.head<2>(), uvr_px.x() - uvr_px.z(), 0.1);
  };
  const double inside = density_at({0.0, 0.0, 0.0});
  EXPECT_GT(inside, 0.9);
  EXPECT_NEAR(density_at({1.9, 0.7, -0.9}), inside, 0.05);
  EXPECT_NEAR(density_at({-1.9, -0.7, 0.9}), inside, 0.05);
  EXPECT_LT(density_at({3.0, 0.0, 0.0}), 0.01);
  EXPECT_LT(density_at({0.0, 1.75, 0.0}), 0.01);
  EXPECT_LT(density_at({0.0, 0.0, -2.0}), 0.01);
}

TEST(BoxVolume, OfALengthThatIsNotKnownReachesFarther) {
  const Box3 box = car_at({0.0, 0.5, 12.0}, M_PI / 2);
  const auto density_behind = [&](double length_sigma_m) {
    const Box3Sigma sigma{.center_m = {0.5 * length_sigma_m, 0.1, 0.1}, .size_m = {length_sigma_m, 0.1, 0.1}};
    const tracking::PredictedVolume volume = volume_of(box, sigma, Eigen::Matrix3d::Zero(), {}, kGeometry);
    const Eigen::Vector3d uvr_px = kGeometry.project({0.0, 0.5, 15.0});
    return volume.density_at(uvr_px.head<2>(), uvr_px.x() - uvr_px.z(), 0.1);
  };
  EXPECT_LT(density_behind(0.2), 0.01) << "a metre behind the rear";
  EXPECT_GT(density_behind(2.0), 0.3);
}

}  // namespace
}  // namespace kinetrace::pipeline
