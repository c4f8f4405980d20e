#include "kinetrace/trajectory/stereo_position_filter.hpp"

#include <cmath>
#include <random>

#include <Eigen/Cholesky>
#include <gtest/gtest.h>

namespace kinetrace::trajectory {
namespace {

constexpr std::int64_t kFrame_ns = 100'000'000;
const StereoGeometry kGeometry{721.0, 721.0, 610.0, 173.0, 0.54, 1242, 375};

Eigen::Vector3d see(const Se3& T_world_cam, const Eigen::Vector3d& p_world) {
  const Eigen::Vector3d seen = kGeometry.project(T_world_cam.inverse() * p_world);
  return {seen[0], seen[1], seen[0] - seen[2]};
}

struct Noise {
  explicit Noise(double sigma, unsigned seed) : sigma_px(sigma), random(seed) {}
  Eigen::Vector3d operator()(const Eigen::Vector3d& uvd) {
    return uvd + sigma_px * Eigen::Vector3d(gauss(random), gauss(random), gauss(random));
  }
  double sigma_px;
  std::mt19937 random;
  std::normal_distribution<double> gauss;
};

TEST(StereoPositionFilter, FollowsAnObjectFromAMovingCamera) {
  TrajectoryConfig config;
  config.stereo_sigma_px = 0.3;
  StereoPositionFilter filter(config, kGeometry);
  Noise noise(0.3, 1);
  const Eigen::Vector3d velocity(-2.0, 0.0, -6.0);
  Eigen::Vector3d position;
  for (int i = 0; i < 30; ++i) {
    const Se3 T_world_cam{so3_exp({0.0, 0.01 * i, 0.0}), {0.0, 0.0, 0.8 * i}};
    position = Eigen::Vector3d(6.0, 1.0, 60.0) + velocity * (0.1 * i);
    filter.predict(i * kFrame_ns);
    EXPECT_TRUE(filter.update(noise(see(T_world_cam, position)), 1, T_world_cam)) << i;
  }
  EXPECT_TRUE(filter.initialised());
  EXPECT_LT((filter.position_m() - position).norm(), 0.5);
  EXPECT_LT((filter.velocity_mps() - velocity).norm(), 1.5);
}

TEST(StereoPositionFilter, ADirectionCorrectsWhatGoesAcrossTheViewAndLeavesDepth) {
  StereoPositionFilter filter({}, kGeometry);
  const Eigen::Vector3d position(2.0, 0.5, 30.0);
  const Eigen::Matrix3d spread = 0.25 * Eigen::Matrix3d::Identity();
  filter.start(0, position, {3.0, 0.0, 0.0}, spread);  // In truth it stands.
  for (int i = 1; i <= 20; ++i) {
    filter.predict(i * kFrame_ns);
    filter.update_direction(see({}, position).head<2>(), {}, 0.5);
  }
  EXPECT_LT((filter.position_m() - position).head<2>().norm(), 0.3) << "went on, it would be six metres off";
  EXPECT_LT(std::abs(filter.velocity_mps().x()), 1.0);
  EXPECT_NEAR(filter.position_m().z(), position.z(), 1.0);
  EXPECT_GT(filter.position_covariance()(2, 2), 4.0 * filter.position_covariance()(0, 0));
}

TEST(StereoPositionFilter, ADirectionSaysNothingOfWhatIsBehindTheCameraOrUnknown) {
  StereoPositionFilter filter({}, kGeometry);
  filter.update_direction({600.0, 170.0}, {}, 0.5);
  EXPECT_FALSE(filter.initialised());
  const Eigen::Vector3d behind(0.0, 0.0, -5.0);
  filter.start(0, behind, Eigen::Vector3d::Zero(), Eigen::Matrix3d::Identity());
  filter.update_direction({100.0, 170.0}, {}, 0.5);
  EXPECT_EQ(filter.position_m(), behind);
}

/// A camera that drives past something at 60 m. More and more of it comes into sight from behind something else: the
/// middle of what is seen stays where it is, while it goes at 4 m/s.
class StereoPositionFilterBehind : public ::testing::Test {
 protected:
  static constexpr double kFrame_s = 1e-9 * kFrame_ns;
  const Eigen::Vector3d velocity_{-4.0, 0.0, 0.0};

  static Se3 camera(int frame) { return {so3_exp({0.0, 0.002 * frame, 0.0}), {0.0, 0.0, 0.8 * frame}}; }
  [[nodiscard]] Eigen::Vector3d corner(int frame) const {
    return Eigen::Vector3d(8.0, 1.0, 60.0) + frame * kFrame_s * velocity_;
  }
  [[nodiscard]] ImageMotion motion(int frame) const {
    return {.now_px = see(camera(frame), corner(frame)).head<2>(),
            .before_px = see(camera(frame - 1), corner(frame - 1)).head<2>(),
            .features = 4};
  }
  /// After eight frames, reported of their features' motion or not.
  [[nodiscard]] StereoPositionFilter filter_after(bool reported) const {
    StereoPositionFilter filter({}, kGeometry);
    for (int frame = 0; frame <= 8; ++frame) {
      filter.predict(frame * kFrame_ns);
      if (reported && frame > 0) {
        filter.update_motion(motion(frame), kFrame_s, camera(frame), camera(frame - 1));
      }
      EXPECT_TRUE(filter.update(see(camera(frame), corner(0)), 4, camera(frame), 2.0));
    }
    return filter;
  }
};

TEST_F(StereoPositionFilterBehind, FeaturesTellHowFastItGoesWhateverIsSeenOfIt) {
  EXPECT_LT((filter_after(true).velocity_mps() - velocity_).head<2>().norm(), 0.5);
  EXPECT_GT((filter_after(false).velocity_mps() - velocity_).head<2>().norm(), 3.0) << "what is seen does not move";
}

TEST_F(StereoPositionFilterBehind, TakesNoMotionThatCannotBeItsOwn) {
  StereoPositionFilter filter = filter_after(true);
  const StereoPositionFilter before = filter;
  ImageMotion wrong = motion(8);
  wrong.before_px.x() += 60.0;
  filter.update_motion(wrong, kFrame_s, camera(8), camera(7));
  EXPECT_EQ(filter.velocity_mps(), before.velocity_mps());
  filter.update_motion({.now_px = {1.0, 1.0}, .before_px = {1.0, 1.0}, .features = 0}, kFrame_s, camera(8), camera(7));
  EXPECT_EQ(filter.velocity_mps(), before.velocity_mps()) << "no features";
  filter.update_motion(motion(8), 0.0, camera(8), camera(7));
  EXPECT_EQ(filter.velocity_mps(), before.velocity_mps()) << "no time";
  filter.update_motion(motion(8), kFrame_s, {so3_exp({0.0, 3.0, 0.0}), {0.0, 0.0, 6.4}}, camera(7));
  EXPECT_EQ(filter.velocity_mps(), before.velocity_mps()) << "behind the camera";
  StereoPositionFilter unstarted({}, kGeometry);
  unstarted.update_motion(motion(8), kFrame_s, camera(8), camera(7));
  EXPECT_FALSE(unstarted.initialised());
}

TEST(StereoPositionFilter, CovarianceIsThatOfStereo) {
  TrajectoryConfig config;
  config.stereo_sigma_px = 0.5;
  StereoPositionFilter filter(config, kGeometry);
  filter.predict(0);
  const Eigen::Vector3d position(0.0, 0.0, 40.0);
  ASSERT_TRUE(filter.update(see({}, position), 1, {}));
  const double depth_sigma = 40.0 * 40.0 / (721.0 * 0.54) * 0.5;
  EXPECT_NEAR(std::sqrt(filter.position_covariance()(2, 2)), depth_sigma, 1e-6);
  EXPECT_NEAR(std::sqrt(filter.position_covariance()(0, 0)), 40.0 / 721.0 * 0.5, 1e-6);
  StereoPositionFilter sharper(config, kGeometry);
  ASSERT_TRUE(sharper.update(see({}, position), 100, {}));
  EXPECT_NEAR(std::sqrt(sharper.position_covariance()(2, 2)), 0.5 * depth_sigma, 1e-6);
}

TEST(StereoPositionFilter, CovarianceMatchesTheScatter) {
  TrajectoryConfig config;
  config.max_acceleration_mps2 = 1.0;
  double normalised = 0.0;
  constexpr int kTrials = 200;
  for (unsigned trial = 0; trial < kTrials; ++trial) {
    StereoPositionFilter filter(config, kGeometry);
    Noise noise(config.stereo_sigma_px, trial);
    std::normal_distribution<double> gauss;
    Eigen::Vector3d position(3.0, 1.0, 25.0);
    Eigen::Vector3d velocity(5.0 * gauss(noise.random), 5.0 * gauss(noise.random), 5.0 * gauss(noise.random));
    velocity *= 0.3;
    for (int i = 0; i < 15; ++i) {
      filter.predict(i * kFrame_ns);
      (void)filter.update(noise(see({}, position)), 1, {});
      if (i == 14) {
        const Eigen::Vector3d error = filter.position_m() - position;
        normalised += error.dot(filter.position_covariance().ldlt().solve(error)) / (3.0 * kTrials);
      }
      const Eigen::Vector3d acceleration(gauss(noise.random), gauss(noise.random), gauss(noise.random));
      position += 0.1 * velocity + 0.005 * acceleration;
      velocity += 0.1 * acceleration;
    }
  }
  EXPECT_NEAR(normalised, 1.0, 0.25);
}

TEST(StereoPositionFilter, PredictsAtConstantVelocityWithGrowingDoubt) {
  StereoPositionFilter filter({}, kGeometry);
  filter.start(0, {0.0, 0.0, 20.0}, {1.0, 0.0, -2.0}, 0.01 * Eigen::Matrix3d::Identity());
  filter.predict(5 * kFrame_ns);
  EXPECT_LT((filter.position_m() - Eigen::Vector3d(0.5, 0.0, 19.0)).norm(), 1e-9);
  EXPECT_GT(filter.position_covariance()(0, 0), 1.0);
  const Eigen::Vector3d before = filter.position_m();
  filter.predict(5 * kFrame_ns);
  filter.predict(2 * kFrame_ns);
  EXPECT_EQ(filter.position_m(), before) << "time does not run back";
}

TEST(StereoPositionFilter, SkipsAnImplausiblePositionAndRestartsAtTheThird) {
  StereoPositionFilter filter({}, kGeometry);
  const Eigen::Vector3d here(0.0, 0.0, 20.0);
  const Eigen::Vector3d elsewhere(8.0, 0.0, 20.0);
  int frame = 0;
  for (; frame < 10; ++frame) {
    filter.predict(frame * kFrame_ns);
    ASSERT_TRUE(filter.update(see({}, here), 4, {}));
  }
  for (int repetition = 0; repetition < 2; ++repetition) {
    filter.predict(frame++ * kFrame_ns);
    EXPECT_FALSE(filter.update(see({}, elsewhere), 4, {}));
    EXPECT_LT((filter.position_m() - here).norm(), 0.5);
  }
  filter.predict(frame++ * kFrame_ns);
  EXPECT_TRUE(filter.update(see({}, elsewhere), 4, {}));
  EXPECT_LT((filter.position_m() - elsewhere).norm(), 1e-9);

  filter.predict(frame++ * kFrame_ns);
  EXPECT_FALSE(filter.update(see({}, here), 4, {}));
  filter.predict(frame++ * kFrame_ns);
  EXPECT_TRUE(filter.update(see({}, elsewhere), 4, {})) << "a single skip is forgotten";
}

TEST(StereoPositionFilter, AWanderingSurfaceIsFollowedSlowlyAndNotTakenForAJump) {
  const Eigen::Vector3d rear(0.0, 0.0, 12.0);
  const Eigen::Vector3d side(0.8, 0.0, 12.6);
  const auto step_after = [&](double surface_sigma_m) {
    StereoPositionFilter filter({}, kGeometry);
    int frame = 0;
    for (; frame < 20; ++frame) {
      filter.predict(frame * kFrame_ns);
      EXPECT_TRUE(filter.update(see({}, rear), 4, {}, surface_sigma_m));
    }
    filter.predict(frame * kFrame_ns);
    const bool taken = filter.update(see({}, side), 4, {}, surface_sigma_m);
    return taken ? (filter.position_m() - rear).norm() : -1.0;
  };
  EXPECT_EQ(step_after(0.0), -1.0);
  EXPECT_GT(step_after(0.5), 0.05);
  EXPECT_LT(step_after(0.5), 0.5);
}

TEST(StereoPositionFilter, RefusesWhatIsNoMeasurement) {
  StereoPositionFilter filter({}, kGeometry);
  filter.predict(0);
  EXPECT_FALSE(filter.update({600.0, 170.0, 0.0}, 3, {}));
  EXPECT_FALSE(filter.update({600.0, 170.0, -1.0}, 3, {}));
  EXPECT_FALSE(filter.update({std::nan(""), 170.0, 5.0}, 3, {}));
  EXPECT_FALSE(filter.update({600.0, 170.0, 5.0}, 0, {}));
  EXPECT_FALSE(filter.initialised());
}

TEST(StereoPositionFilter, RecoversWhenThePredictionIsBehindTheCamera) {
  StereoPositionFilter filter({}, kGeometry);
  filter.start(0, {0.0, 0.0, -5.0}, Eigen::Vector3d::Zero(), 0.1 * Eigen::Matrix3d::Identity());
  const Eigen::Vector3d there(1.0, 0.0, 15.0);
  EXPECT_FALSE(filter.update(see({}, there), 4, {}));
  EXPECT_FALSE(filter.update(see({}, there), 4, {}));
  EXPECT_TRUE(filter.update(see({}, there), 4, {}));
  EXPECT_LT((filter.position_m() - there).norm(), 1e-9);
}

}  // namespace
}  // namespace kinetrace::trajectory
