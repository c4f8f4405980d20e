// The reported covariance is that of the actual errors.
#include <Eigen/Cholesky>
#include <gtest/gtest.h>

#include "bundle_scene.hpp"
#include "fixed_solver.hpp"

namespace kinetrace::refinement {
namespace {

TEST(BundleCovariance, MatchesTheScatterOfTheNewestPose) {
  constexpr int kTrials = 300;
  FixedSolver solver(patient_config());
  Matrix6d residual_sigma = Matrix6d::Zero();
  Matrix6d predicted = Matrix6d::Zero();
  double normalised = 0.0;
  for (int trial = 0; trial < kTrials; ++trial) {
    SceneOptions options;
    options.frames = 6;
    options.points = 60;
    options.track_frames = 4;
    options.noise_px = 0.5;
    options.pose_error_m = 0.02;
    // Far from the body's origin, where the left perturbation couples rotation and translation strongly.
    options.T_body_start = {so3_exp({0.2, -0.5, 0.1}), {30.0, -5.0, 20.0}};
    options.seed = static_cast<std::uint32_t>(100 + trial);
    BundleScene scene = make_scene(options);
    BundleWindow window = scene.window();
    const auto summary = solver.adjuster.refine(window);
    ASSERT_TRUE(summary);
    const Vector6d error = left_difference(scene.true_T_body_cam.back(), scene.T_body_cam.back());
    residual_sigma += error * error.transpose() / kTrials;
    predicted += summary->newest_covariance / kTrials;
    normalised += error.dot(summary->newest_covariance.ldlt().solve(error)) / (6.0 * kTrials);
  }
  EXPECT_NEAR(normalised, 1.0, 0.2);
  for (int i = 0; i < 6; ++i) {
    EXPECT_NEAR(residual_sigma(i, i) / predicted(i, i), 1.0, 0.3) << i;
  }
}

}  // namespace
}  // namespace kinetrace::refinement
