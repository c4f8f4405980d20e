#include "kinetrace/refinement/ceres_bundle_adjuster.hpp"

#include <bit>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "bundle_scene.hpp"
#include "fixed_solver.hpp"

namespace kinetrace::refinement {
namespace {

/// A trajectory longer than any window, with short tracks.
struct BatchScene {
  StereoGeometry geometry{721.0, 721.0, 610.0, 173.0, 0.54, 1242, 375};
  std::vector<Se3> true_T_body_cam;
  std::vector<Se3> T_body_cam;
  std::vector<Eigen::Vector3d> points_m;
  std::vector<BatchObservation> observations;
  std::vector<std::uint32_t> fixed_frames{0};

  [[nodiscard]] BatchProblem problem() { return {geometry, T_body_cam, fixed_frames, points_m, observations}; }
};

BatchScene make_batch(int frames) {
  std::mt19937 random(5);
  std::normal_distribution<double> gauss;
  std::uniform_real_distribution<double> uniform(-1.0, 1.0);
  BatchScene scene;
  for (int k = 0; k < frames; ++k) {
    scene.true_T_body_cam.push_back({so3_exp({0.0, 0.02 * k, 0.0}), {0.0, 0.0, 0.5 * k}});
    Vector6d error;
    for (int i = 0; i < 6; ++i) {
      error[i] = (k == 0 ? 0.0 : 1.0) * gauss(random) * (i < 3 ? 0.003 : 0.03);
    }
    scene.T_body_cam.push_back(scene.true_T_body_cam.back() * left_update(Se3{}, error));
  }
  for (int first = 0; first + 4 <= frames; ++first) {
    for (int n = 0; n < 12; ++n) {
      const double z = 12.0 + 8.0 * uniform(random);
      const Eigen::Vector3d p = scene.true_T_body_cam[static_cast<std::size_t>(first)] *
                                Eigen::Vector3d(0.5 * z * uniform(random), 0.2 * z * uniform(random), z);
      const auto id = static_cast<std::uint32_t>(scene.points_m.size());
      scene.points_m.emplace_back(p * (1.0 + 0.01 * gauss(random)));
      for (int k = first; k < first + 4; ++k) {
        const Eigen::Vector3d seen =
            scene.geometry.project(scene.true_T_body_cam[static_cast<std::size_t>(k)].inverse() * p);
        scene.observations.push_back(
            {id,
             static_cast<std::uint32_t>(k),
             {static_cast<float>(seen[0]), static_cast<float>(seen[1]), static_cast<float>(seen[2]), 3.F}});
      }
    }
  }
  return scene;
}

TEST(CeresBundleAdjuster, RefinesATrajectoryLongerThanAnyWindow) {
  BatchScene scene = make_batch(80);
  CeresBundleAdjuster adjuster = patient_ceres();
  BatchProblem problem = scene.problem();
  const auto summary = adjuster.refine_batch(problem);
  ASSERT_TRUE(summary) << summary.error().message;
  EXPECT_TRUE(summary->converged);
  const PoseDifference d = largest_difference(scene.T_body_cam, scene.true_T_body_cam);
  EXPECT_LT(d.position_m, 2e-3);
  EXPECT_LT(d.angle_rad, 1e-4);
}

TEST(CeresBundleAdjuster, FixedPosesAndPosesWithoutObservationsStay) {
  BatchScene scene = make_batch(20);
  scene.fixed_frames = {0, 7};
  std::erase_if(scene.observations, [](const BatchObservation& o) { return o.frame == 12; });
  const BatchScene before = scene;
  CeresBundleAdjuster adjuster = patient_ceres();
  BatchProblem problem = scene.problem();
  ASSERT_TRUE(adjuster.refine_batch(problem));
  EXPECT_EQ(scene.T_body_cam[7].translation, before.T_body_cam[7].translation);
  EXPECT_EQ(scene.T_body_cam[12].rotation, before.T_body_cam[12].rotation);
  EXPECT_NE(scene.T_body_cam[8].translation, before.T_body_cam[8].translation);
}

TEST(CeresBundleAdjuster, RejectsBadBatches) {
  CeresBundleAdjuster adjuster = patient_ceres();
  const auto refused = [&adjuster](void (*spoil)(BatchScene&)) {
    BatchScene scene = make_batch(6);
    spoil(scene);
    BatchProblem problem = scene.problem();
    const auto result = adjuster.refine_batch(problem);
    return result ? std::string("accepted") : result.error().message;
  };
  EXPECT_EQ(refused([](BatchScene&) {}), "accepted");
  EXPECT_THAT(refused([](BatchScene& s) { s.fixed_frames.clear(); }), testing::HasSubstr("no fixed frame"));
  EXPECT_THAT(refused([](BatchScene& s) { s.fixed_frames = {6}; }), testing::HasSubstr("fixed frame 6"));
  EXPECT_THAT(refused([](BatchScene& s) { s.observations[4].frame = 6; }), testing::HasSubstr("batch observation 4"));
  EXPECT_THAT(refused([](BatchScene& s) { s.observations[4].point = 1000; }), testing::HasSubstr("observation 4"));
  EXPECT_THAT(refused([](BatchScene& s) { s.observations[4].observation.v_px = kNoRight; }),
              testing::HasSubstr("not finite"));
  EXPECT_THAT(refused([](BatchScene& s) { s.T_body_cam[2].translation.x() = std::nan(""); }),
              testing::HasSubstr("pose of batch frame 2"));
  EXPECT_THAT(refused([](BatchScene& s) { s.geometry.baseline_m = -1.0; }), testing::HasSubstr("baseline"));
}

TEST(CeresBundleAdjuster, LeavesProblemsWithoutFreeParametersAlone) {
  BatchScene scene = make_batch(6);
  scene.fixed_frames = {0, 1, 2, 3, 4, 5};
  const BatchScene before = scene;
  CeresBundleAdjuster adjuster = patient_ceres();
  BatchProblem problem = scene.problem();
  const auto summary = adjuster.refine_batch(problem);
  ASSERT_TRUE(summary);
  EXPECT_EQ(summary->iterations, 0);
  EXPECT_EQ(scene.points_m[0], before.points_m[0]);
  BatchProblem empty;
  EXPECT_FALSE(adjuster.refine_batch(empty)) << "no geometry";
  BundleWindow empty_window;
  EXPECT_TRUE(adjuster.refine(empty_window));
}

/// Mean squared normalised error of the last pose over many draws of the noise.
double normalised_error() {
  constexpr int kTrials = 60;
  std::mt19937 random(77);
  std::normal_distribution<double> gauss;
  double sum = 0.0;
  for (int trial = 0; trial < kTrials; ++trial) {
    BatchScene scene = make_batch(12);
    for (BatchObservation& seen : scene.observations) {
      const double sigma_px = 1.0 / static_cast<double>(seen.observation.inverse_sigma_px);
      seen.observation.u_left_px += static_cast<float>(sigma_px * gauss(random));
      seen.observation.v_px += static_cast<float>(sigma_px * gauss(random));
      seen.observation.u_right_px += static_cast<float>(sigma_px * gauss(random));
    }
    CeresBundleAdjuster adjuster = CeresBundleAdjuster::create({.robust_threshold_sigmas = 100.0}).value();
    BatchProblem problem = scene.problem();
    EXPECT_TRUE(adjuster.refine_batch(problem));
    const auto covariances = adjuster.pose_covariances(problem);
    EXPECT_TRUE(covariances) << covariances.error().message;
    const Vector6d error = left_difference(scene.true_T_body_cam.back().inverse(), scene.T_body_cam.back().inverse());
    sum += error.dot(covariances->back().llt().solve(error)) / 6.0 / kTrials;
  }
  return sum;
}

TEST(CeresBundleAdjuster, CovariancesOfPosesAreHonest) {
  const double error = normalised_error();
  EXPECT_GT(error, 0.8);
  EXPECT_LT(error, 1.25);
}

TEST(CeresBundleAdjuster, FixedPosesHaveNoCovariance) {
  BatchScene scene = make_batch(20);
  scene.fixed_frames = {3};
  BatchProblem problem = scene.problem();
  const CeresBundleAdjuster adjuster = patient_ceres();
  const auto covariances = adjuster.pose_covariances(problem);
  ASSERT_TRUE(covariances);
  ASSERT_EQ(covariances->size(), 20U);
  EXPECT_EQ((*covariances)[3], Matrix6d::Zero());
  for (std::size_t k = 4; k < 20; ++k) {
    EXPECT_GT((*covariances)[k].trace(), 0.0) << k;
  }
  EXPECT_GT((*covariances)[19].trace(), (*covariances)[4].trace()) << "it grows with the way from there";
}

TEST(CeresBundleAdjuster, RefusesCovariancesOfTooManyPoses) {
  BatchScene scene = make_batch(10);
  scene.T_body_cam.resize(CeresBundleAdjuster::kMaxCovarianceFrames + 1);
  BatchProblem problem = scene.problem();
  EXPECT_FALSE(patient_ceres().pose_covariances(problem));
}

TEST(CeresBundleConfig, NamesTheKeyThatIsOutOfRange) {
  CeresBundleConfig config;
  config.threads = 0;
  const auto refused = CeresBundleAdjuster::create(config);
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().message, "refinement.batch.threads must be at least 1, got 0");
}

}  // namespace
}  // namespace kinetrace::refinement
