#include "kinetrace/objects/motion_filter.hpp"

#include <cmath>
#include <optional>
#include <random>

#include <Eigen/Cholesky>
#include <gtest/gtest.h>

namespace kinetrace::objects {
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

constexpr double kFrame_s = 1e-9 * kFrame_ns;

StereoPosition stereo(const Eigen::Vector3d& uvd_px, int features = 4, double extent_sigma_m = 0.0) {
  return {uvd_px, features, {.covariance_m2 = extent_sigma_m * extent_sigma_m * Eigen::Matrix3d::Identity()}};
}

MotionStart at(const Eigen::Vector3d& position_m, double sigma_m = 0.5) {
  MotionStart start;
  start.pose.T_world_obj.translation = position_m;
  start.pose.covariance.bottomRightCorner<3, 3>() = sigma_m * sigma_m * Eigen::Matrix3d::Identity();
  start.velocity_covariance = 25.0 * Eigen::Matrix3d::Identity();
  return start;
}

/// A start with a known velocity.
MotionStart moving_at(const Eigen::Vector3d& position_m, const Eigen::Vector3d& velocity_mps,
                      double moving_probability = 0.99) {
  MotionStart start = at(position_m, 0.05);
  start.velocity.tail<3>() = velocity_mps;
  start.velocity_covariance = 0.01 * Eigen::Matrix3d::Identity();
  start.moving_probability = moving_probability;
  return start;
}

MotionFilter started(const MotionStart& start, const MotionNoise& noise = {}) {
  MotionFilter filter(noise, kGeometry);
  filter.start(start);
  return filter;
}

Eigen::Matrix3d position_covariance(const MotionFilter& filter) {
  return filter.pose_covariance().bottomRightCorner<3, 3>();
}

TEST(MotionFilter, AVelocityIsWeightedByItsCovariance) {
  MotionStart start = moving_at({0.0, 1.0, 60.0}, {0.0, 0.0, -90.0});
  start.velocity_covariance = 2500.0 * Eigen::Matrix3d::Identity();
  EXPECT_LT(started(start).velocity_mps().norm(), 20.0) << "a path of a few frames, far away";
  const Eigen::Vector3d fast(0.0, 0.0, -40.0);
  EXPECT_LT((started(moving_at({0.0, 1.0, 60.0}, fast)).velocity_mps() - fast).norm(), 0.2);
}

TEST(MotionFilter, AnUncertainDepthFromAboveLiftsNothing) {
  const Eigen::Vector3d ray = Eigen::Vector3d(0.0, 1.0, 1.0).normalized();
  MotionStart start = moving_at({0.0, 10.0, 20.0}, Eigen::Vector3d(5.0, 0.0, 0.0) - 4.0 * ray);
  start.velocity_covariance = 0.04 * Eigen::Matrix3d::Identity() + 16.0 * ray * ray.transpose();
  const auto velocity = [&](const std::optional<Eigen::Vector3d>& vertical) {
    MotionFilter filter({}, kGeometry);
    filter.set_vertical(vertical);
    filter.start(start);
    return filter.velocity_mps();
  };
  EXPECT_LT(velocity(std::nullopt).y(), -2.0);
  EXPECT_GT(velocity(Eigen::Vector3d::UnitY()).y(), -0.7);
  EXPECT_NEAR(velocity(Eigen::Vector3d::UnitY()).x(), 5.0, 0.1);
}

TEST(MotionFilter, FollowsAnObjectFromAMovingCamera) {
  const Eigen::Vector3d velocity(-2.0, 0.0, -6.0);
  Eigen::Vector3d position(6.0, 1.0, 60.0);
  MotionFilter filter = started(at(position, 5.0), {.stereo_sigma_px = 0.3});
  Noise noise(0.3, 1);
  for (int i = 0; i < 30; ++i) {
    const Se3 T_world_cam{so3_exp({0.0, 0.01 * i, 0.0}), {0.0, 0.0, 0.8 * i}};
    position = Eigen::Vector3d(6.0, 1.0, 60.0) + velocity * (0.1 * i);
    filter.predict(i * kFrame_ns);
    EXPECT_TRUE(filter.update(stereo(noise(see(T_world_cam, position)), 1), T_world_cam)) << i;
  }
  EXPECT_GT(filter.moving_probability(), 0.9);
  EXPECT_LT((filter.pose().translation - position).norm(), 0.5);
  EXPECT_LT((filter.velocity_mps() - velocity).norm(), 1.5);
}

TEST(MotionFilter, ABearingCorrectsWhatGoesAcrossTheViewAndLeavesDepth) {
  const Eigen::Vector3d position(2.0, 0.5, 30.0);  // The true object is static.
  MotionStart start = moving_at(position, {3.0, 0.0, 0.0});
  start.pose.covariance.bottomRightCorner<3, 3>() = 0.25 * Eigen::Matrix3d::Identity();
  MotionFilter filter = started(start);
  for (int i = 1; i <= 20; ++i) {
    filter.predict(i * kFrame_ns);
    filter.update(Bearing{.uv_px = see({}, position).head<2>(), .center_sigma_m = 0.5, .part = {}}, {});
  }
  EXPECT_LT((filter.pose().translation - position).head<2>().norm(), 0.3)
      << "at constant velocity it would be six metres off";
  EXPECT_LT(std::abs(filter.velocity_mps().x()), 1.0);
  EXPECT_NEAR(filter.pose().translation.z(), position.z(), 1.0);
}

TEST(MotionFilter, ABearingSaysNothingOfWhatIsBehindTheCameraOrUnknown) {
  MotionFilter unstarted({}, kGeometry);
  const Bearing seen{.uv_px = {100.0, 170.0}, .center_sigma_m = 0.5, .part = {}};
  EXPECT_FALSE(unstarted.update(seen, {}));
  const Eigen::Vector3d behind(0.0, 0.0, -5.0);
  MotionFilter filter = started(at(behind));
  EXPECT_FALSE(filter.update(seen, {}));
  EXPECT_EQ(filter.pose().translation, behind);
}

/// A camera drives past an object at 60 m that emerges from behind an occluder: the middle of its visible part stays in
/// place, while the object moves at 4 m/s.
class MotionFilterBehind : public ::testing::Test {
 protected:
  const Eigen::Vector3d velocity_{-4.0, 0.0, 0.0};

  static Se3 camera(int frame) { return {so3_exp({0.0, 0.002 * frame, 0.0}), {0.0, 0.0, 0.8 * frame}}; }
  [[nodiscard]] Eigen::Vector3d corner(int frame) const {
    return Eigen::Vector3d(8.0, 1.0, 60.0) + frame * kFrame_s * velocity_;
  }
  [[nodiscard]] ImageMotion motion(int frame) const {
    return {.now_px = see(camera(frame), corner(frame)).head<2>(),
            .before_px = see(camera(frame - 1), corner(frame - 1)).head<2>(),
            .features = 4,
            .interval_s = kFrame_s,
            .T_world_cam_before = camera(frame - 1)};
  }
  /// The filter after eight frames, with or without the motion of their features.
  [[nodiscard]] MotionFilter filter_after(bool with_motion) const {
    MotionFilter filter = started(at(corner(0), 2.0));
    for (int frame = 0; frame <= 8; ++frame) {
      filter.predict(frame * kFrame_ns);
      if (with_motion && frame > 0) {
        filter.update(motion(frame), camera(frame));
      }
      EXPECT_TRUE(filter.update(stereo(see(camera(frame), corner(0)), 4, 2.0), camera(frame)));
    }
    return filter;
  }
};

TEST_F(MotionFilterBehind, FeaturesTellHowFastItGoesWhateverIsSeenOfIt) {
  EXPECT_GT(filter_after(true).moving_probability(), 0.9);
  EXPECT_LT((filter_after(true).velocity_mps() - velocity_).head<2>().norm(), 0.5);
  EXPECT_GT((filter_after(false).velocity_mps() - velocity_).head<2>().norm(), 3.0) << "what is seen does not move";
}

TEST_F(MotionFilterBehind, TakesNoMotionThatCannotBeItsOwn) {
  MotionFilter filter = filter_after(true);
  const Eigen::Vector3d before = filter.velocity_mps();
  ImageMotion wrong = motion(8);
  wrong.before_px.x() += 120.0;
  EXPECT_FALSE(filter.update(wrong, camera(8)));
  ImageMotion none = motion(8);
  none.features = 0;
  EXPECT_FALSE(filter.update(none, camera(8))) << "no features";
  ImageMotion at_once = motion(8);
  at_once.interval_s = 0.0;
  EXPECT_FALSE(filter.update(at_once, camera(8))) << "no time";
  EXPECT_FALSE(filter.update(motion(8), {so3_exp({0.0, 3.0, 0.0}), {0.0, 0.0, 6.4}})) << "behind the camera";
  EXPECT_EQ(filter.velocity_mps(), before);
  MotionFilter unstarted({}, kGeometry);
  EXPECT_FALSE(unstarted.update(motion(8), camera(8)));
}

TEST(MotionFilter, CovarianceIsThatOfStereo) {
  const Eigen::Vector3d position(0.0, 0.0, 40.0);
  const auto covariance_of = [&](int features) {
    MotionFilter filter = started(at(position, 1e4));
    EXPECT_TRUE(filter.update(stereo(see({}, position), features), {}));
    return position_covariance(filter);
  };
  const double depth_sigma = 40.0 * 40.0 / (721.0 * 0.54) * 0.5;
  EXPECT_NEAR(std::sqrt(covariance_of(1)(2, 2)), depth_sigma, 1e-3);
  EXPECT_NEAR(std::sqrt(covariance_of(1)(0, 0)), 40.0 / 721.0 * 0.5, 1e-3);
  EXPECT_NEAR(std::sqrt(covariance_of(100)(2, 2)), 0.5 * depth_sigma, 1e-3);
}

TEST(MotionFilter, CovarianceMatchesTheScatter) {
  const MotionNoise motion_noise{.prior = {.acceleration_mps2 = 1.0}};
  double normalised = 0.0;
  constexpr int kTrials = 200;
  for (unsigned trial = 0; trial < kTrials; ++trial) {
    Noise noise(motion_noise.stereo_sigma_px, trial);
    std::normal_distribution<double> gauss;
    Eigen::Vector3d position(3.0, 1.0, 25.0);
    Eigen::Vector3d velocity(3.0 + gauss(noise.random), gauss(noise.random), gauss(noise.random));
    MotionFilter filter = started(at(position, 2.0), motion_noise);
    for (int i = 0; i < 15; ++i) {
      filter.predict(i * kFrame_ns);
      (void)filter.update(stereo(noise(see({}, position)), 1), {});
      if (i == 14) {
        const Eigen::Vector3d error = filter.pose().translation - position;
        normalised += error.dot(position_covariance(filter).ldlt().solve(error)) / (3.0 * kTrials);
      }
      const Eigen::Vector3d acceleration(gauss(noise.random), gauss(noise.random), gauss(noise.random));
      position += 0.1 * velocity + 0.005 * acceleration;
      velocity += 0.1 * acceleration;
    }
  }
  EXPECT_NEAR(normalised, 1.0, 0.25);
}

TEST(MotionFilter, PredictsAtConstantVelocityWithGrowingCovariance) {
  MotionFilter filter = started(moving_at({0.0, 0.0, 20.0}, {1.0, 0.0, -2.0}));
  const UncertainPose foreseen = filter.predicted(5 * kFrame_ns);
  EXPECT_LT((foreseen.T_world_obj.translation - Eigen::Vector3d(0.5, 0.0, 19.0)).norm(), 1e-4);
  filter.predict(5 * kFrame_ns);
  EXPECT_LT((filter.pose().translation - foreseen.T_world_obj.translation).norm(), 1e-3);
  EXPECT_GT(position_covariance(filter)(0, 0), 0.2);
  const Se3 before = filter.pose();
  filter.predict(5 * kFrame_ns);
  filter.predict(2 * kFrame_ns);
  EXPECT_EQ(filter.pose().translation, before.translation) << "time does not run back";
}

TEST(MotionFilter, CovarianceGrowsByTimeAtAnyRate) {
  const auto sigma_after_a_second = [](int frames) {
    MotionFilter filter = started(moving_at({0.0, 0.0, 20.0}, {1.0, 0.0, -2.0}));
    for (int i = 1; i <= frames; ++i) {
      filter.predict(i * (std::int64_t{1'000'000'000} / frames));
    }
    return std::sqrt(position_covariance(filter)(0, 0));
  };
  EXPECT_NEAR(sigma_after_a_second(30), sigma_after_a_second(10), 0.02 * sigma_after_a_second(10));
}

// Of a second without a measurement.
TEST(MotionFilter, StaysOnTheGroundWhereThatIsKnown) {
  const Eigen::Vector3d vertical = Eigen::Vector3d(0.0, 1.0, 0.5).normalized();
  const Eigen::Vector3d along = Eigen::Vector3d::UnitX();
  const auto sigma_m = [](const MotionFilter& filter, const Eigen::Vector3d& direction) {
    return std::sqrt(direction.dot(position_covariance(filter) * direction));
  };
  const auto unseen = [&](const std::optional<Eigen::Vector3d>& normal) {
    MotionFilter filter(MotionNoise{}, kGeometry);
    filter.set_vertical(normal);
    MotionStart start = moving_at({0.0, 0.0, 20.0}, {1.0, 0.0, -2.0});
    filter.start(start);
    filter.predict(10 * kFrame_ns);
    return filter;
  };
  EXPECT_LT(sigma_m(unseen(vertical), vertical), 0.5 * sigma_m(unseen(vertical), along));
  EXPECT_NEAR(sigma_m(unseen(std::nullopt), vertical), sigma_m(unseen(std::nullopt), along), 1e-5);
  EXPECT_NEAR(sigma_m(unseen(vertical), along), sigma_m(unseen(std::nullopt), along), 1e-5);
}

TEST(MotionFilter, ATurnContinuesAndRotatesTheVelocity) {
  MotionStart start = moving_at({0.0, 0.0, 20.0}, {5.0, 0.0, 0.0});
  start.velocity[1] = -0.5;
  MotionFilter filter = started(start);
  for (int i = 1; i <= 10; ++i) {
    filter.predict(i * kFrame_ns);
  }
  EXPECT_LT((filter.pose().rotation - so3_exp({0.0, -0.5, 0.0})).norm(), 1e-6);
  EXPECT_LT((filter.velocity_mps() - so3_exp({0.0, -0.5, 0.0}) * Eigen::Vector3d(5.0, 0.0, 0.0)).norm(), 0.01);
}

TEST(MotionFilter, WhatRestsStaysAndIsSoonKnownToRest) {
  MotionFilter filter = started(moving_at({2.0, 0.0, 15.0}, {0.4, 0.0, 0.0}, 0.01));
  for (int i = 1; i <= 50; ++i) {
    filter.predict(i * kFrame_ns);
  }
  EXPECT_TRUE(filter.at_rest());
  EXPECT_LT((filter.pose().translation - Eigen::Vector3d(2.0, 0.0, 15.0)).norm(), 0.02);
  EXPECT_LT(std::sqrt(position_covariance(filter)(0, 0)), 0.3);
}

TEST(MotionFilter, WhatIsSeenDecidesBetweenGoneOnAndStopped) {
  const Eigen::Vector3d start(2.0, 0.0, 15.0);
  const Eigen::Vector3d velocity(3.0, 0.0, 0.0);
  const auto moving_after = [&](const Eigen::Vector3d& truth_mps) {
    MotionFilter filter = started(moving_at(start, velocity, 0.5));
    for (int i = 1; i <= 12; ++i) {
      filter.predict(i * kFrame_ns);
      EXPECT_TRUE(filter.update(stereo(see({}, start + i * kFrame_s * truth_mps), 4, 0.3), {})) << i;
    }
    EXPECT_LT((filter.pose().translation - start - 12 * kFrame_s * truth_mps).norm(), 0.5);
    return filter.moving_probability();
  };
  EXPECT_GT(moving_after(velocity), 0.9);
  EXPECT_LT(moving_after(Eigen::Vector3d::Zero()), 0.2);
}

TEST(MotionFilter, ComesToRestOnlyFromALowSpeed) {
  const Eigen::Vector3d start(-6.0, 0.0, 15.0);
  constexpr double kSpeed_mps = 8.0;
  const auto moving_after = [&](int frames, double brake_mps2, double extent_sigma_m) {
    MotionFilter filter = started(moving_at(start, {kSpeed_mps, 0.0, 0.0}));
    Eigen::Vector3d position_m = start;
    double speed_mps = kSpeed_mps;
    for (int i = 1; i <= frames; ++i) {
      speed_mps = std::max(speed_mps - brake_mps2 * kFrame_s, 0.0);
      position_m.x() += speed_mps * kFrame_s;
      filter.predict(i * kFrame_ns);
      filter.update(stereo(see({}, position_m), 4, extent_sigma_m), {});
    }
    return filter.moving_probability();
  };
  EXPECT_GT(moving_after(18, 4.0, 0.3), 0.98) << "braking, at 0.8 m/s";
  EXPECT_LT(moving_after(70, 4.0, 0.3), 0.5) << "at rest for five seconds";
  EXPECT_GT(moving_after(15, 1000.0, 1.5), 0.7) << "another part of it, or another object";
}

TEST(MotionFilter, RefusesAnImplausiblePositionAndRestartsThereWhenAsked) {
  const Eigen::Vector3d here(0.0, 0.0, 20.0);
  const StereoPosition elsewhere = stereo(see({}, {8.0, 0.0, 20.0}));
  MotionFilter filter = started(at(here));
  int frame = 0;
  for (; frame < 10; ++frame) {
    filter.predict(frame * kFrame_ns);
    ASSERT_TRUE(filter.update(stereo(see({}, here)), {}));
  }
  filter.predict(frame++ * kFrame_ns);
  EXPECT_FALSE(filter.update(elsewhere, {}));
  EXPECT_LT((filter.pose().translation - here).norm(), 0.5);
  filter.restart_at(elsewhere, {});
  EXPECT_LT((filter.pose().translation - Eigen::Vector3d(8.0, 0.0, 20.0)).norm(), 1e-9);
  EXPECT_TRUE(filter.update(elsewhere, {}));
}

TEST(MotionFilter, LikelihoodsOfPlacesFallWithDistanceAndWithTheExtentOfTheBody) {
  const Eigen::Vector3d here(0.0, 0.0, 20.0);
  MotionFilter filter = started(at(here));
  const auto log_likelihood = [&](double beside_m, double extent_sigma_m) {
    const Eigen::Vector3d place = here + Eigen::Vector3d(beside_m, 0.0, 0.0);
    return filter.log_likelihood(stereo(see({}, place), 4, extent_sigma_m), {}).value();
  };
  EXPECT_GT(log_likelihood(0.0, 0.0), log_likelihood(0.5, 0.0));
  EXPECT_LT(log_likelihood(12.0, 0.0), log_likelihood(0.0, 0.0) - 8.0);
  EXPECT_LT(log_likelihood(0.0, 2.0), log_likelihood(0.0, 0.0)) << "anywhere on a large body";
  EXPECT_GT(log_likelihood(3.0, 2.0), log_likelihood(3.0, 0.0));
  filter.reset();
  EXPECT_FALSE(filter.log_likelihood(stereo(see({}, here)), {}));
}

/// A filter that has measured `here` for `frames` frames, its visible part uncertain by `extent_sigma_m`.
MotionFilter measured_at(const Eigen::Vector3d& here, int frames, double extent_sigma_m) {
  MotionStart start = moving_at(here, Eigen::Vector3d::Zero(), 0.01);
  start.part_covariance_m2 = extent_sigma_m * extent_sigma_m * Eigen::Matrix3d::Identity();
  MotionFilter filter = started(start);
  for (int frame = 1; frame <= frames; ++frame) {
    filter.predict(frame * kFrame_ns);
    EXPECT_TRUE(filter.update(stereo(see({}, here), 4, extent_sigma_m), {}));
  }
  return filter;
}

TEST(MotionFilter, AnErrorThatStaysIsNotAveragedAway) {
  const Eigen::Vector3d here(0.0, 0.0, 20.0);
  const double certain_m2 = position_covariance(measured_at(here, 20, 0.0))(0, 0);
  const double extended_m2 = position_covariance(measured_at(here, 20, 1.0))(0, 0);
  EXPECT_GT(extended_m2, 2.0 * certain_m2);
  EXPECT_GT(extended_m2, position_covariance(measured_at(here, 0, 1.0))(0, 0)) << "the start was more certain";
}

TEST(MotionFilter, WhereTheVisiblePartIsKnownBetterThanTheObject) {
  const Eigen::Vector3d here(0.0, 0.0, 20.0);
  const MotionFilter filter = measured_at(here, 20, 1.0);
  const VisiblePart part{.covariance_m2 = Eigen::Matrix3d::Identity()};
  const UncertainPosition seen = filter.predicted_part(20 * kFrame_ns, part);
  EXPECT_LT((seen.position_m - here).norm(), 0.01);
  EXPECT_LT(seen.covariance(0, 0), 0.2 * position_covariance(filter)(0, 0));
  const VisiblePart half_hidden{.covariance_m2 = 4.0 * Eigen::Matrix3d::Identity()};
  EXPECT_NEAR(filter.predicted_part(20 * kFrame_ns, half_hidden).covariance(0, 0), seen.covariance(0, 0) + 3.0, 1e-9)
      << "what has just been hidden may shift it";
}

TEST(MotionFilter, WhatIsHiddenShiftsWhatIsSeenAndNotTheObject) {
  const Eigen::Vector3d here(0.0, 0.0, 20.0);
  const StereoPosition shifted = stereo(see({}, here + Eigen::Vector3d(1.0, 0.0, 0.0)), 4, 1.5);
  MotionFilter whole = measured_at(here, 20, 0.0);
  EXPECT_FALSE(whole.update(stereo(shifted.uvd_px), {}));
  EXPECT_TRUE(whole.update(shifted, {}));
  EXPECT_LT((whole.pose().translation - here).norm(), 0.1);
}

TEST(MotionFilter, ASlowlyVaryingSurfaceIsFollowedSlowlyAndNotTakenForAJump) {
  const Eigen::Vector3d rear(0.0, 0.0, 12.0);
  const Eigen::Vector3d side(0.8, 0.0, 12.6);
  const auto step_after = [&](double extent_sigma_m) {
    MotionFilter filter = started(at(rear));
    int frame = 0;
    for (; frame < 20; ++frame) {
      filter.predict(frame * kFrame_ns);
      EXPECT_TRUE(filter.update(stereo(see({}, rear), 4, extent_sigma_m), {}));
    }
    filter.predict(frame * kFrame_ns);
    const bool taken = filter.update(stereo(see({}, side), 4, extent_sigma_m), {});
    return taken ? (filter.pose().translation - rear).norm() : -1.0;
  };
  EXPECT_EQ(step_after(0.0), -1.0);
  EXPECT_GT(step_after(0.5), 0.02);
  EXPECT_LT(step_after(0.5), 0.5);
}

TEST(MotionFilter, TheSeenPointMayLieBesideTheOrigin) {
  const Eigen::Vector3d origin(0.0, 0.0, 20.0);
  const Eigen::Vector3d to_origin_m(1.0, -0.5, 2.0);
  StereoPosition seen = stereo(see({}, origin - to_origin_m));
  seen.part.to_origin_m = to_origin_m;
  MotionFilter filter = started(at(origin + Eigen::Vector3d(0.3, 0.0, 0.0)));
  EXPECT_TRUE(filter.update(seen, {}));
  EXPECT_LT((filter.pose().translation - origin).head<2>().norm(), 0.01);
}

TEST(MotionFilter, TheMotionOfANearSideTellsTheVelocityWhereverTheOriginLies) {
  const Eigen::Vector3d velocity_mps(3.0, 0.0, 0.0);
  const Eigen::Vector3d to_origin_m(0.0, 0.0, 6.0);
  const auto side = [&](int frame) {
    return Eigen::Vector3d(Eigen::Vector3d(-1.0, 0.5, 10.0) + frame * kFrame_s * velocity_mps);
  };
  MotionFilter filter = started(at(side(0) + to_origin_m));
  for (int frame = 1; frame <= 6; ++frame) {
    filter.predict(frame * kFrame_ns);
    EXPECT_TRUE(filter.update(ImageMotion{.now_px = see({}, side(frame)).head<2>(),
                                          .before_px = see({}, side(frame - 1)).head<2>(),
                                          .to_origin_m = to_origin_m,
                                          .features = 4,
                                          .interval_s = kFrame_s,
                                          .T_world_cam_before = {}},
                              {}));
  }
  EXPECT_LT((filter.velocity_mps() - velocity_mps).head<2>().norm(), 0.3);
}

TEST(MotionFilter, RefusesWhatIsNoMeasurement) {
  MotionFilter filter = started(at({0.0, 0.0, 20.0}));
  EXPECT_FALSE(filter.update(stereo({600.0, 170.0, 0.0}), {}));
  EXPECT_FALSE(filter.update(stereo({600.0, 170.0, -1.0}), {}));
  EXPECT_FALSE(filter.update(stereo({std::nan(""), 170.0, 5.0}), {}));
  EXPECT_FALSE(filter.update(stereo({600.0, 170.0, 5.0}, 0), {}));
  EXPECT_FALSE(filter.update(Bearing{.uv_px = {std::nan(""), 0.0}, .part = {}}, {}));
  filter.reset();
  EXPECT_FALSE(filter.update(stereo({610.0, 173.0, 19.5}), {}));
}

}  // namespace
}  // namespace kinetrace::objects
