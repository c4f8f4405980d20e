#include "kinetrace/core/stereo_geometry.hpp"

#include <random>

#include <gtest/gtest.h>

#include "kinetrace/core/se3.hpp"
#include "kinetrace/core/stereo_reprojection.hpp"
#include "synthetic_world.hpp"

namespace kinetrace {
namespace {

const StereoGeometry kRig = test::street_rig();
const ReprojectionModel<double> kModel{kRig.fx_px, kRig.fy_px, kRig.cx_px, kRig.cy_px, kRig.fx_px* kRig.baseline_m};

Eigen::Vector3d residual_at(const Eigen::Vector3d& p) {
  const auto r = stereo_reprojection<double>(kModel, p.x(), p.y(), p.z(), 600.0, 200.0, 580.0);
  return {r.residual[0], r.residual[1], r.residual[2]};
}

Eigen::Matrix3d derivative_at(const Eigen::Vector3d& p) {
  const auto r = stereo_reprojection<double>(kModel, p.x(), p.y(), p.z(), 600.0, 200.0, 580.0);
  Eigen::Matrix3d d;
  d << r.du_dx, 0.0, r.du_left_dz, 0.0, r.dv_dy, r.dv_dz, r.du_dx, 0.0, r.du_right_dz;
  return d;
}

TEST(StereoGeometry, TriangulateUndoesProject) {
  for (const Eigen::Vector3d& p :
       {Eigen::Vector3d(0.0, 0.0, 1.0), Eigen::Vector3d(-3.0, 1.5, 12.0), Eigen::Vector3d(20.0, -4.0, 80.0)}) {
    const Eigen::Vector3d uvr = kRig.project(p);
    EXPECT_LT((kRig.triangulate(uvr.x(), uvr.y(), uvr.x() - uvr.z()) - p).norm(), 1e-10);
  }
}

TEST(StereoGeometry, DepthSigmaIsTheSlopeOfTheDepth) {
  constexpr double kSmall_px = 1e-4;
  for (const double disparity_px : {2.0, 20.0}) {
    const double change_m = kRig.depth_m(disparity_px) - kRig.depth_m(disparity_px + kSmall_px);
    EXPECT_NEAR(kRig.depth_sigma_m(kRig.depth_m(disparity_px), 0.3) / (0.3 * change_m / kSmall_px), 1.0, 1e-3);
  }
}

TEST(StereoGeometry, TheRightCameraIsTheLeftOneMovedByTheBaseline) {
  const Eigen::Vector3d p(-3.0, 1.5, 12.0);
  const Eigen::Vector3d from_right = p - Eigen::Vector3d(kRig.baseline_m, 0.0, 0.0);
  EXPECT_NEAR(kRig.project(p).z(), kRig.project(from_right).x(), 1e-10);
  EXPECT_NEAR(kRig.depth_m(kRig.disparity_px(7.0)), 7.0, 1e-12);
}

TEST(StereoReprojection, ResidualIsPredictedMinusObserved) {
  const Eigen::Vector3d p(-3.0, 1.5, 12.0);
  EXPECT_LT((residual_at(p) - (kRig.project(p) - Eigen::Vector3d(600.0, 200.0, 580.0))).norm(), 1e-10);
}

TEST(StereoReprojection, PointDerivativesMatchNumericOnes) {
  std::mt19937 engine(3);
  std::uniform_real_distribution<double> x(-8.0, 8.0);
  std::uniform_real_distribution<double> z(1.0, 60.0);
  constexpr double kStep = 1e-5;
  for (int trial = 0; trial < 50; ++trial) {
    const Eigen::Vector3d p(x(engine), x(engine), z(engine));
    const Eigen::Matrix3d d = derivative_at(p);
    for (int i = 0; i < 3; ++i) {
      const Eigen::Vector3d h = kStep * Eigen::Vector3d::Unit(i);
      const Eigen::Vector3d numeric = (residual_at(p + h) - residual_at(p - h)) / (2.0 * kStep);
      EXPECT_LT((numeric - d.col(i)).norm(), 1e-5 * (1.0 + d.col(i).norm()));
    }
  }
}

TEST(StereoReprojection, PoseDerivativesMatchNumericOnes) {
  const Se3 T_cam_body{so3_exp({0.1, -0.2, 0.05}), {0.5, -0.3, 2.0}};
  const Eigen::Vector3d p_body(1.0, -2.0, 9.0);
  const Eigen::Vector3d p_cam = T_cam_body * p_body;
  Eigen::Matrix<double, 3, 6> d;
  d << derivative_at(p_cam) * -skew(p_cam), derivative_at(p_cam);
  constexpr double kStep = 1e-6;
  for (int i = 0; i < 6; ++i) {
    const Vector6d xi = kStep * Vector6d::Unit(i);
    const Eigen::Vector3d numeric =
        (residual_at(left_update(T_cam_body, xi) * p_body) - residual_at(left_update(T_cam_body, -xi) * p_body)) /
        (2.0 * kStep);
    EXPECT_LT((numeric - d.col(i)).norm(), 1e-5 * (1.0 + d.col(i).norm())) << "column " << i;
  }
}

}  // namespace
}  // namespace kinetrace
