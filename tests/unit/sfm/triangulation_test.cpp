#include "kinetrace/sfm/triangulation.hpp"

#include <array>

#include <gtest/gtest.h>

#include "synthetic_world.hpp"

namespace kinetrace::sfm {
namespace {

using kinetrace::test::driven;

const StereoGeometry kRig = kinetrace::test::street_rig();
constexpr double kOneDegree = 0.01745;

BundleObservation seen_from(const Se3& T_body_cam, const Eigen::Vector3d& p_body, bool stereo) {
  const Eigen::Vector3d uvr = kRig.project(T_body_cam.inverse() * p_body);
  return {static_cast<float>(uvr.x()), static_cast<float>(uvr.y()), stereo ? static_cast<float>(uvr.z()) : kNoRight};
}

TEST(Triangulate, OneStereoPairPlacesAPoint) {
  const Eigen::Vector3d p(-2.0, 1.0, 15.0);
  const std::array<Se3, 1> poses{Se3{so3_exp({0.0, 0.3, 0.0}), {1.0, 2.0, 3.0}}};
  const std::array<BundleObservation, 1> row{seen_from(poses[0], p, true)};
  const auto found = triangulate(kRig, poses, row, 1U, 0.01);
  ASSERT_TRUE(found);
  EXPECT_LT((*found - p).norm(), 2e-4);
}

TEST(Triangulate, TemporalViewsOfOneCameraPlaceAPoint) {
  const Eigen::Vector3d p(-4.0, 1.0, 15.0);
  const std::array<Se3, 3> poses{driven(0.0), driven(1.0), driven(2.0)};
  std::array<BundleObservation, 3> row;
  for (std::size_t k = 0; k < 3; ++k) {
    row[k] = seen_from(poses[k], p, false);
  }
  const auto found = triangulate(kRig, poses, row, 0b111U, kOneDegree);
  ASSERT_TRUE(found);
  EXPECT_LT((*found - p).norm(), 1e-3);
}

TEST(Triangulate, ReadsOnlyTheColumnsThatSeeThePoint) {
  const Eigen::Vector3d p(-4.0, 1.0, 15.0);
  const std::array<Se3, 3> poses{driven(0.0), driven(1.0), driven(2.0)};
  std::array<BundleObservation, 3> row{seen_from(poses[0], p, false), {1.F, 1.F, 0.F}, seen_from(poses[2], p, false)};
  const auto found = triangulate(kRig, poses, row, 0b101U, kOneDegree);
  ASSERT_TRUE(found);
  EXPECT_LT((*found - p).norm(), 1e-3);
}

TEST(Triangulate, NoParallaxIsNoPoint) {
  const Eigen::Vector3d p(-4.0, 1.0, 15.0);
  const std::array<Se3, 2> standing{Se3{}, Se3{}};
  std::array<BundleObservation, 2> row{seen_from(Se3{}, p, false), seen_from(Se3{}, p, false)};
  EXPECT_FALSE(triangulate(kRig, standing, row, 0b11U, kOneDegree));
  // One view, one view.
  EXPECT_FALSE(triangulate(kRig, standing, row, 0b01U, kOneDegree));
  // No view at all.
  EXPECT_FALSE(triangulate(kRig, standing, row, 0U, kOneDegree));
  // A point at 500 m, rays .06 degrees apart.
  const Eigen::Vector3d far(0.0, 0.0, 500.0);
  row = {seen_from(Se3{}, far, true), seen_from(Se3{}, far, true)};
  EXPECT_FALSE(triangulate(kRig, standing, row, 0b11U, kOneDegree));
}

TEST(Triangulate, AStraightAheadPointHasNoTemporalParallax) {
  const Eigen::Vector3d p(0.0, 0.0, 30.0);
  const std::array<Se3, 2> poses{driven(0.0), driven(5.0)};
  const std::array<BundleObservation, 2> row{seen_from(poses[0], p, false), seen_from(poses[1], p, false)};
  EXPECT_FALSE(triangulate(kRig, poses, row, 0b11U, kOneDegree));
}

TEST(Triangulate, RaysThatMeetBehindACameraAreNoPoint) {
  const std::array<Se3, 1> poses{Se3{}};
  // A negative disparity.
  const std::array<BundleObservation, 1> row{BundleObservation{600.F, 170.F, 640.F}};
  EXPECT_FALSE(triangulate(kRig, poses, row, 1U, 0.001));
}

TEST(Triangulate, TheWidestPairOfRaysCountsNotTheFirst) {
  // Views in a row: the angle between the outer ones is enough, that from the first one to any other is not.
  const Eigen::Vector3d p(0.0, 0.0, 20.0);
  const std::array<Se3, 3> poses{kinetrace::test::turned(0.0, {0.0, 0.0, 0.0}),
                                 kinetrace::test::turned(0.0, {-0.25, 0.0, 0.0}),
                                 kinetrace::test::turned(0.0, {0.25, 0.0, 0.0})};
  std::array<BundleObservation, 3> row;
  for (std::size_t k = 0; k < 3; ++k) {
    row[k] = seen_from(poses[k], p, false);
  }
  EXPECT_TRUE(triangulate(kRig, poses, row, 0b111U, kOneDegree));
}

}  // namespace
}  // namespace kinetrace::sfm
