#include "kinetrace/sfm/stereo_pose_estimator.hpp"

#include <random>
#include <vector>

#include <gtest/gtest.h>

#include "synthetic_world.hpp"

namespace kinetrace::sfm {
namespace {

using kinetrace::test::rotation_error_deg;

constexpr double kSigma_px = 0.3;

/// Points of a body in front of the rig, and their observations.
class Scene {
 public:
  Scene(std::size_t points, std::uint32_t seed) : engine_(seed) {
    for (std::size_t i = 0; i < points; ++i) {
      const Eigen::Vector3d p_cam = rig_.triangulate(uniform(0.0, 1242.0), uniform(0.0, 375.0),
                                                     rig_.disparity_px(5.0 * std::pow(12.0, uniform(0.0, 1.0))));
      p_body_.push_back(T_cam_body_.inverse() * p_cam);
    }
  }

  std::vector<PoseObservation> observe(double sigma_px) {
    std::normal_distribution<double> noise(0.0, sigma_px);
    std::vector<PoseObservation> out;
    for (const Eigen::Vector3d& p : p_body_) {
      const Eigen::Vector3d uvr = rig_.project(T_cam_body_ * p);
      out.push_back({p, static_cast<float>(uvr.x() + noise(engine_)), static_cast<float>(uvr.y() + noise(engine_)),
                     static_cast<float>(uvr.z() + noise(engine_))});
    }
    return out;
  }
  /// Replaces the first `count` observations by random ones.
  void spoil(std::vector<PoseObservation>& observations, std::size_t count) {
    for (std::size_t i = 0; i < count; ++i) {
      observations[i].u_left_px = static_cast<float>(uniform(0.0, 1242.0));
      observations[i].v_px = static_cast<float>(uniform(0.0, 375.0));
      observations[i].u_right_px = observations[i].u_left_px - static_cast<float>(uniform(1.0, 100.0));
    }
  }
  [[nodiscard]] const Se3& truth() const { return T_cam_body_; }
  [[nodiscard]] const StereoGeometry& rig() const { return rig_; }
  [[nodiscard]] Se3 off_by(double angle_rad, double metres) const {
    Vector6d xi = Vector6d::Zero();
    xi[1] = angle_rad;
    xi[5] = metres;
    return left_update(T_cam_body_, xi);
  }
  [[nodiscard]] StereoPoseEstimator estimator() const { return StereoPoseEstimator({}, rig_); }
  [[nodiscard]] double position_error_m(const PoseEstimate& e) const {
    return (e.T_cam_body.inverse().translation - T_cam_body_.inverse().translation).norm();
  }

 private:
  double uniform(double low, double high) { return std::uniform_real_distribution<double>(low, high)(engine_); }
  StereoGeometry rig_ = kinetrace::test::street_rig();
  Se3 T_cam_body_{so3_exp({0.05, -0.4, 0.02}), {1.0, -0.5, 3.0}};
  std::vector<Eigen::Vector3d> p_body_;
  std::mt19937 engine_;
};

/// An initial pose without weight.
PosePrior guess(const Se3& T_cam_body) {
  return {T_cam_body, Matrix6d::Zero()};
}

TEST(StereoPoseEstimator, FollowsAStrongPriorWhereObservationsSayLittle) {
  Scene scene(4, 3);
  const auto observations = scene.observe(0.0);
  std::vector<std::uint8_t> inlier(4);
  PosePrior prior = guess(scene.off_by(0.0, 0.001));
  prior.information = 1e12 * Matrix6d::Identity();
  const PoseEstimate e = scene.estimator().estimate(observations, prior, kSigma_px, inlier);
  ASSERT_TRUE(e.valid);
  EXPECT_LT(left_difference(prior.T_cam_body, e.T_cam_body).norm(), 1e-4);
}

TEST(StereoPoseEstimator, IsExactWithoutNoise) {
  for (const std::size_t n : {3, 4, 50, 500}) {
    Scene scene(n, 1);
    const auto observations = scene.observe(0.0);
    std::vector<std::uint8_t> inlier(n);
    const PoseEstimate e = scene.estimator().estimate(observations, guess(scene.off_by(0.05, 0.8)), kSigma_px, inlier);
    ASSERT_TRUE(e.valid) << n;
    EXPECT_EQ(e.inliers, static_cast<int>(n));
    EXPECT_LT(scene.position_error_m(e), n == 3 ? 1e-3 : 1e-4) << n;  // Pixels are floats.
    EXPECT_LT(rotation_error_deg(e.T_cam_body, scene.truth()), n == 3 ? 1e-2 : 1e-3) << n;
  }
}

TEST(StereoPoseEstimator, FewerThanThreePointsAreNoPose) {
  for (const std::size_t n : {0, 1, 2}) {
    Scene scene(n, 1);
    std::vector<std::uint8_t> inlier(n, 1);
    const PoseEstimate e = scene.estimator().estimate(scene.observe(0.0), guess(scene.truth()), kSigma_px, inlier);
    EXPECT_FALSE(e.valid);
    EXPECT_EQ(std::count(inlier.begin(), inlier.end(), 1), 0);
  }
}

TEST(StereoPoseEstimator, NoiseLeavesMillimetres) {
  Scene scene(500, 2);
  std::vector<std::uint8_t> inlier(500);
  const PoseEstimate e =
      scene.estimator().estimate(scene.observe(kSigma_px), guess(scene.off_by(0.02, 0.5)), kSigma_px, inlier);
  ASSERT_TRUE(e.valid);
  EXPECT_GT(e.inliers, 495);
  EXPECT_LT(scene.position_error_m(e), 0.01);
  EXPECT_LT(rotation_error_deg(e.T_cam_body, scene.truth()), 0.02);
}

TEST(StereoPoseEstimator, FindsThePoseAmongFortyPercentOutliers) {
  for (std::uint32_t seed = 1; seed <= 10; ++seed) {
    Scene scene(100, seed);
    auto observations = scene.observe(kSigma_px);
    scene.spoil(observations, 40);
    std::vector<std::uint8_t> inlier(100);
    const PoseEstimate e = scene.estimator().estimate(observations, guess(scene.off_by(0.08, 1.0)), kSigma_px, inlier);
    ASSERT_TRUE(e.valid);
    EXPECT_LE(std::count(inlier.begin(), inlier.begin() + 40, 1), 1);
    EXPECT_GE(std::count(inlier.begin() + 40, inlier.end(), 1), 58);
    EXPECT_LT(scene.position_error_m(e), 0.03) << "seed " << seed;
    EXPECT_LT(rotation_error_deg(e.T_cam_body, scene.truth()), 0.1) << "seed " << seed;
  }
}

TEST(StereoPoseEstimator, ConsensusDecideAgainstAMajorityThatMoves) {
  constexpr std::size_t kConsensus = 15;
  Scene scene(60, 7);
  std::vector<PoseObservation> observations = scene.observe(kSigma_px);
  // All the others lie on one moved object.
  const Eigen::Vector3d step(0.4, 0.0, 0.1);
  for (std::size_t i = kConsensus; i < observations.size(); ++i) {
    observations[i].p_body += step;
  }
  std::vector<std::uint8_t> inlier(observations.size());
  const PoseEstimate e =
      scene.estimator().estimate(observations, guess(scene.off_by(0.01, 0.1)), kSigma_px, inlier, kConsensus);
  ASSERT_TRUE(e.valid);
  EXPECT_LT(scene.position_error_m(e), 0.1);
  EXPECT_GE(e.agreeing_consensus, 14);
  EXPECT_EQ(e.inliers, std::count(inlier.begin(), inlier.end(), 1));
  const PoseEstimate all = scene.estimator().estimate(observations, guess(scene.truth()), kSigma_px, inlier);
  EXPECT_GT(scene.position_error_m(all), 0.3) << "where all have a vote, the majority is accepted";
}

TEST(StereoPoseEstimator, NothingButOutliersIsHardlyEverAPose) {
  Scene scene(100, 5);
  auto observations = scene.observe(kSigma_px);
  scene.spoil(observations, 100);
  std::vector<std::uint8_t> inlier(100);
  const PoseEstimate e = scene.estimator().estimate(observations, guess(scene.truth()), kSigma_px, inlier);
  EXPECT_LT(e.inliers, 8);
}

TEST(StereoPoseEstimator, PointsBehindTheCameraNeverAgree) {
  Scene scene(60, 3);
  auto observations = scene.observe(kSigma_px);
  for (std::size_t i = 0; i < 10; ++i) {  // The mirrored point projects to the same place.
    const Eigen::Vector3d p_cam = scene.truth() * observations[i].p_body;
    observations[i].p_body = scene.truth().inverse() * Eigen::Vector3d(-p_cam);
  }
  std::vector<std::uint8_t> inlier(60);
  const PoseEstimate e = scene.estimator().estimate(observations, guess(scene.truth()), kSigma_px, inlier);
  ASSERT_TRUE(e.valid);
  EXPECT_EQ(std::count(inlier.begin(), inlier.begin() + 10, 1), 0);
  EXPECT_LT(scene.position_error_m(e), 0.05);
}

TEST(StereoPoseEstimator, EveryPointBehindTheCameraIsNoPose) {
  Scene scene(20, 3);
  auto observations = scene.observe(0.0);
  const Se3 facing_away{so3_exp({0.0, 3.14159, 0.0}) * scene.truth().rotation, Eigen::Vector3d::Zero()};
  for (PoseObservation& o : observations) {
    o.p_body = facing_away.inverse() * Eigen::Vector3d(0.0, 0.0, -10.0);
  }
  std::vector<std::uint8_t> inlier(20);
  EXPECT_FALSE(scene.estimator().estimate(observations, guess(facing_away), kSigma_px, inlier).valid);
}

TEST(StereoPoseEstimator, OneCameraIsEnoughOncePointsAreKnown) {
  Scene scene(200, 4);
  auto observations = scene.observe(kSigma_px);
  for (PoseObservation& o : observations) {
    o.u_right_px = kNoRight;
  }
  std::vector<std::uint8_t> inlier(200);
  const PoseEstimate e = scene.estimator().estimate(observations, guess(scene.off_by(0.02, 0.5)), kSigma_px, inlier);
  ASSERT_TRUE(e.valid);
  EXPECT_GT(e.inliers, 197);
  EXPECT_LT(scene.position_error_m(e), 0.03);
}

TEST(StereoPoseEstimator, CovarianceMatchesMonteCarlo) {
  Scene scene(60, 6);
  constexpr int kTrials = 600;
  Matrix6d sampled = Matrix6d::Zero();
  Matrix6d claimed = Matrix6d::Zero();
  std::vector<std::uint8_t> inlier(60);
  for (int trial = 0; trial < kTrials; ++trial) {
    const PoseEstimate e =
        scene.estimator().estimate(scene.observe(kSigma_px), guess(scene.truth()), kSigma_px, inlier);
    ASSERT_TRUE(e.valid);
    const Vector6d error = left_difference(scene.truth(), e.T_cam_body);
    sampled += error * error.transpose() / kTrials;
    claimed += e.covariance / kTrials;
  }
  for (int i = 0; i < 6; ++i) {
    EXPECT_NEAR(claimed(i, i) / sampled(i, i), 1.0, 0.2) << "axis " << i;  // Three standard deviations of the sample.
  }
  // The claimed ellipsoid has the right shape too: normalised errors have mean square 6.
  EXPECT_NEAR((claimed.inverse() * sampled).trace(), 6.0, 0.6);
}

TEST(StereoPoseEstimator, SameInputSameOutputBitForBit) {
  Scene scene(300, 7);
  auto observations = scene.observe(kSigma_px);
  scene.spoil(observations, 120);
  std::vector<std::uint8_t> first_inlier(300);
  std::vector<std::uint8_t> second_inlier(300);
  const PoseEstimate first =
      scene.estimator().estimate(observations, guess(scene.off_by(0.05, 0.5)), kSigma_px, first_inlier);
  const PoseEstimate second =
      scene.estimator().estimate(observations, guess(scene.off_by(0.05, 0.5)), kSigma_px, second_inlier);
  EXPECT_EQ(first.T_cam_body.rotation, second.T_cam_body.rotation);
  EXPECT_EQ(first.T_cam_body.translation, second.T_cam_body.translation);
  EXPECT_EQ(first_inlier, second_inlier);
}

TEST(ReprojectionChi2, CountsTwoTermsForOneCameraAndThreeForTwo) {
  const StereoGeometry rig = kinetrace::test::street_rig();
  const Eigen::Vector3d p(1.0, 0.5, 10.0);
  const Eigen::Vector3d uvr = rig.project(p);
  const PoseObservation stereo{p, static_cast<float>(uvr.x() + 1.0), static_cast<float>(uvr.y() - 2.0),
                               static_cast<float>(uvr.z() + 2.0)};
  PoseObservation mono = stereo;
  mono.u_right_px = kNoRight;
  EXPECT_NEAR(reprojection_chi2(rig, Se3{}, stereo, 0.5), 36.0, 1e-2);
  EXPECT_NEAR(reprojection_chi2(rig, Se3{}, mono, 0.5), 20.0, 1e-2);
}

}  // namespace
}  // namespace kinetrace::sfm
