// The portable and the fast kernels compute the same; the Cholesky solver solves.
#include "bundle_kernel.hpp"

#include <random>
#include <vector>

#include <Eigen/Cholesky>
#include <gtest/gtest.h>

#include "bundle_scene.hpp"
#include "kinetrace/core/arena.hpp"
#include "kinetrace/core/cpu.hpp"
#include "packed_window.hpp"
#include "reprojection_jacobian.hpp"

namespace kinetrace::refinement {
namespace {

TEST(ReprojectionJacobian, EqualsNumericDerivativesForPointAndPose) {
  const StereoGeometry geometry{721.0, 719.0, 610.0, 173.0, 0.54, 1242, 375};
  const Se3 T_cam_body{so3_exp({0.1, -0.3, 0.2}), {0.5, -0.2, 1.0}};
  const Eigen::Vector3d point(1.0, -0.7, 9.0);
  const BundleObservation seen{600.F, 150.F, 560.F, 2.F};
  const auto residual = [&](const Se3& pose, const Eigen::Vector3d& p) {
    return reprojection_jacobian(geometry, seen, pose * p).residual;
  };
  const Eigen::Vector3d p_cam = T_cam_body * point;
  const ReprojectionJacobian analytic = reprojection_jacobian(geometry, seen, p_cam);
  ASSERT_TRUE(analytic.in_front);
  constexpr double kStep = 1e-6;
  for (int i = 0; i < 3; ++i) {
    const Eigen::Vector3d e = kStep * Eigen::Vector3d::Unit(i);
    const Eigen::Vector3d numeric = (residual(T_cam_body, point + e) - residual(T_cam_body, point - e)) / (2.0 * kStep);
    EXPECT_LT((numeric - analytic.d_point * T_cam_body.rotation.col(i)).norm(), 1e-5);
  }
  const Eigen::Matrix<double, 3, 6> pose = analytic.d_point * pose_jacobian(p_cam);
  for (int i = 0; i < 6; ++i) {
    const Vector6d e = kStep * Vector6d::Unit(i);
    const Eigen::Vector3d numeric =
        (residual(left_update(T_cam_body, e), point) - residual(left_update(T_cam_body, -e), point)) / (2.0 * kStep);
    EXPECT_LT((numeric - pose.col(i)).norm(), 1e-4);
  }
}

TEST(ReprojectionJacobian, IsConstantBehindTheCamera) {
  const StereoGeometry geometry{721.0, 719.0, 610.0, 173.0, 0.54, 1242, 375};
  const BundleObservation seen{600.F, 150.F, 560.F, 2.F};
  const ReprojectionJacobian r = reprojection_jacobian(geometry, seen, {0.0, 0.0, -2.0});
  EXPECT_FALSE(r.in_front);
  EXPECT_EQ(r.residual.norm(), kBehindCameraSigmas);
  EXPECT_TRUE(r.d_point.isZero());
}

std::vector<const CholeskyKernel*> cholesky_kernels() {
  std::vector<const CholeskyKernel*> kernels{&kernel_baseline::cholesky_kernel};
  if (cpu_runs_fast_kernels()) {
    kernels.push_back(&kernel_fast::cholesky_kernel);
  }
  return kernels;
}

TEST(CholeskyKernel, SolvesSystemsOfEverySizeUpToAFullWindow) {
  std::mt19937 random(3);
  std::normal_distribution<double> gauss;
  for (const CholeskyKernel* kernel : cholesky_kernels()) {
    for (const int size : {1, 2, 3, 4, 5, 6, 7, 54, 66, 186}) {
      const Eigen::MatrixXd root = Eigen::MatrixXd::NullaryExpr(size, size, [&] { return gauss(random); });
      Eigen::Matrix<double, -1, -1, Eigen::RowMajor> a =
          root * root.transpose() + Eigen::MatrixXd::Identity(size, size);
      const Eigen::VectorXd x = Eigen::VectorXd::NullaryExpr(size, [&] { return gauss(random); });
      Eigen::VectorXd b = a * x;
      ASSERT_TRUE(kernel->factorise(a.data(), size, size));
      kernel->solve(a.data(), size, size, b.data());
      EXPECT_LT((b - x).norm(), 1e-8 * size) << size;
    }
  }
}

TEST(CholeskyKernel, RefusesIndefiniteAndNanMatrices) {
  for (const CholeskyKernel* kernel : cholesky_kernels()) {
    double indefinite[4] = {1.0, 0.0, 2.0, 1.0};
    EXPECT_FALSE(kernel->factorise(indefinite, 2, 2));
    double nan[1] = {std::nan("")};
    EXPECT_FALSE(kernel->factorise(nan, 1, 1));
  }
}

/// Both passes of one kernel on a packed window.
struct Passes {
  double cost = 0.0;
  double moved_cost = 0.0;
  std::vector<FrameSums> frames;
  std::vector<BlockSums> blocks;
  std::vector<PointLanes> moved;
};

Passes run(const BundleKernel& kernel, const PackedWindow& packed, const StereoGeometry& geometry) {
  std::vector<KernelPose> poses;
  for (int k = 0; k < packed.frames; ++k) {
    KernelPose pose{};
    const Se3& T_cam_anchor = packed.T_cam_anchor[static_cast<std::size_t>(k)];
    for (int i = 0; i < 9; ++i) {
      pose.rotation[i] = static_cast<float>(T_cam_anchor.rotation(i / 3, i % 3));
    }
    for (int i = 0; i < 3; ++i) {
      pose.translation[i] = static_cast<float>(T_cam_anchor.translation[i]);
    }
    poses.push_back(pose);
  }
  KernelProblem problem;
  problem.model = {721.F, 721.F, 610.F, 173.F, static_cast<float>(721.0 * geometry.baseline_m)};
  problem.min_depth_m = 0.03F;
  problem.robust_scale = 12.F;
  problem.behind_loss = 80.F;
  problem.poses = poses.data();
  problem.free_index = packed.free_index.data();
  problem.free_frames = packed.free_frames;
  problem.groups = packed.group.data();
  problem.group_count = packed.groups;
  problem.observations = packed.observations.data();
  problem.points = packed.current.data();
  Passes out;
  std::vector<PointFactor> factors(static_cast<std::size_t>(packed.groups));
  out.frames.resize(static_cast<std::size_t>(packed.free_frames));
  out.blocks.resize(static_cast<std::size_t>(block_index(packed.free_frames, 0)));
  out.moved.resize(static_cast<std::size_t>(packed.groups));
  out.cost = kernel.eliminate_points(problem, 1e-4F, factors.data(), out.frames.data(), out.blocks.data());
  std::vector<float> step(static_cast<std::size_t>(6 * packed.free_frames), 1e-3F);
  out.moved_cost = kernel.move_points(problem, factors.data(), step.data(), poses.data(), out.moved.data());
  return out;
}

TEST(BundleKernel, PortableAndFastVariantsAgree) {
  if (!cpu_runs_fast_kernels()) {
    GTEST_SKIP() << "only one instruction set is in use here";
  }
  SceneOptions options;
  options.points = 203;
  options.mono_ratio = 0.3;
  BundleScene scene = make_scene(options);
  Arena arena(std::size_t{1} << 22U);
  PackedWindow packed(arena, options.frames, options.points);
  packed.pack(scene.window());
  const Passes a = run(kernel_baseline::bundle_kernel, packed, scene.geometry);
  const Passes b = run(kernel_fast::bundle_kernel, packed, scene.geometry);
  EXPECT_NEAR(a.cost / b.cost, 1.0, 1e-5);
  EXPECT_NEAR(a.moved_cost / b.moved_cost, 1.0, 1e-3);
  const auto sum = [](const Float8& lanes) {
    double total = 0.0;
    for (int lane = 0; lane < kLanes; ++lane) {
      total += static_cast<double>(lanes[lane]);
    }
    return total;
  };
  for (std::size_t i = 0; i < a.frames.size(); ++i) {
    for (int k = 0; k < 21; ++k) {
      const double scale = sum(a.frames[i].hessian[0]) + sum(a.frames[i].hessian[20]);
      EXPECT_NEAR(sum(a.frames[i].hessian[k]), sum(b.frames[i].hessian[k]), 1e-5 * scale);
    }
  }
  for (std::size_t i = 0; i < a.blocks.size(); ++i) {
    for (int k = 0; k < 36; ++k) {
      EXPECT_NEAR(sum(a.blocks[i].entry[k]), sum(b.blocks[i].entry[k]), 1e-4 * sum(a.blocks[0].entry[0]));
    }
  }
  for (std::size_t g = 0; g < a.moved.size(); ++g) {
    for (int lane = 0; lane < kLanes; ++lane) {
      EXPECT_NEAR(a.moved[g].z[lane], b.moved[g].z[lane], 3e-4F * a.moved[g].z[lane]);
    }
  }
}

}  // namespace
}  // namespace kinetrace::refinement
