#include "kinetrace/trajectory/object_motion.hpp"

#include <cmath>
#include <optional>
#include <random>

#include <Eigen/Cholesky>
#include <gtest/gtest.h>

#include "kinetrace/core/allocation_counter.hpp"

namespace kinetrace::trajectory {
namespace {

constexpr std::int64_t kFrame_ns = 100'000'000;
constexpr double kFrame_s = 0.1;

/// Feeds noisy positions of a path to an ObjectMotion.
class Path {
 public:
  explicit Path(double sigma_m, unsigned seed = 1) : sigma_m_(sigma_m), random_(seed) {}

  MotionSample sample(double time_s, const Eigen::Vector3d& position, double yaw_rad = 0.0) {
    MotionSample out;
    out.timestamp_ns = static_cast<std::int64_t>(time_s * 1e9);
    out.T_world_obj = {so3_exp({0.0, yaw_rad, 0.0}),
                       position + sigma_m_ * Eigen::Vector3d(gauss_(random_), gauss_(random_), gauss_(random_))};
    out.position_covariance = sigma_m_ * sigma_m_ * Eigen::Matrix3d::Identity();
    return out;
  }

 private:
  double sigma_m_;
  std::mt19937 random_;
  std::normal_distribution<double> gauss_;
};

TEST(ObjectMotion, KnowsNothingWithoutSamplesAndRestWithOne) {
  ObjectMotion motion({});
  EXPECT_FALSE(motion.at(0).moving);
  Path path(0.01);
  motion.push(path.sample(0.0, {1.0, 0.0, 10.0}));
  EXPECT_EQ(motion.size(), 1U);
  EXPECT_TRUE(motion.at(0).velocity_mps.isZero());
  EXPECT_FALSE(motion.at(0).moving);
  EXPECT_TRUE(motion.at(1).velocity_mps.isZero());
  motion.push(path.sample(0.1, {2.0, 0.0, 10.0}));
  EXPECT_FALSE(motion.at(0).moving) << "two samples";
  EXPECT_TRUE(motion.at(0).velocity_mps.isZero());
  motion.push(path.sample(0.2, {3.0, 0.0, 10.0}));
  EXPECT_TRUE(motion.at(0).moving) << "three samples";
}

TEST(ObjectMotion, FindsAConstantVelocityAtEveryAge) {
  ObjectMotion motion({});
  Path path(0.02);
  const Eigen::Vector3d velocity(-3.0, 0.1, 5.0);
  for (int i = 0; i < 30; ++i) {
    motion.push(path.sample(i * kFrame_s, velocity * (i * kFrame_s)));
  }
  for (const std::size_t age : {0U, 1U, 5U, 10U, 29U}) {
    const MotionEstimate estimate = motion.at(age);
    EXPECT_TRUE(estimate.moving);
    EXPECT_LT((estimate.velocity_mps - velocity).norm(), 0.25) << age;
  }
  EXPECT_LT((motion.at(10).velocity_mps - velocity).norm(), 0.1);
  EXPECT_LT(motion.at(10).covariance.trace(), motion.at(0).covariance.trace());
}

// A camera that drives at 8 m/s past a parked car, all disparities off by half a pixel.
TEST(ObjectMotion, WhatAWrongCalibrationMayHaveMovedIsNotSaidToMove) {
  constexpr double kFb = 720.0 * 0.54;
  constexpr double kOff_px = 0.5;
  const Eigen::Vector3d velocity_mps(0.0, 0.0, 8.0);
  const auto seen_at = [&](double time_s) {
    const Eigen::Vector3d p_cam = Eigen::Vector3d(-4.0, 1.0, 30.0) - time_s * velocity_mps;
    const double disparity_px = kFb / p_cam.z();
    return Eigen::Vector3d(disparity_px / (disparity_px - kOff_px) * p_cam + time_s * velocity_mps);
  };
  const auto per_disparity = [&](double time_s) {
    const Eigen::Vector3d p_cam = seen_at(time_s) - time_s * velocity_mps;
    return velocity_per_disparity(p_cam / p_cam.z(), Eigen::Vector3d::UnitZ(), velocity_mps, kFb / p_cam.z(), 0.0);
  };
  const Eigen::Vector3d seen_mps = (seen_at(0.01) - seen_at(0.0)) / 0.01;
  EXPECT_NEAR(std::sqrt(per_disparity(0.0).trace()) * kOff_px / seen_mps.norm(), 1.0, 0.05);
  for (const double sigma_px : {0.0, kOff_px}) {
    ObjectMotion motion({});
    motion.set_disparity_sigma(sigma_px);
    Path path(0.01);
    for (int i = 0; i < 10; ++i) {
      MotionSample sample = path.sample(i * kFrame_s, seen_at(i * kFrame_s));
      sample.covariance_per_disparity = per_disparity(i * kFrame_s);
      motion.push(sample);
    }
    EXPECT_EQ(motion.at(0).moving, sigma_px == 0.0);
    EXPECT_EQ(motion.at(5).moving, sigma_px == 0.0);
  }
}

TEST(ObjectMotion, CalibrationAddsNoUncertaintyAtRest) {
  EXPECT_TRUE(
      velocity_per_disparity({0.1, 0.0, 1.0}, Eigen::Vector3d::UnitZ(), Eigen::Vector3d::Zero(), 10.0, 20.0).isZero());
}

TEST(ObjectMotion, ParkedObjectStandsStill) {
  for (unsigned seed = 1; seed <= 20; ++seed) {
    ObjectMotion motion({});
    Path path(0.03, seed);
    for (int i = 0; i < 40; ++i) {
      motion.push(path.sample(i * kFrame_s, {4.0, 1.0, 12.0}));
      // The newest velocity uses the past alone; the finalised one uses both sides.
      EXPECT_TRUE(i < 5 || motion.at(0).velocity_mps.norm() < 0.45) << i;
      EXPECT_TRUE(i < 15 || motion.at(10).velocity_mps.norm() < 0.15) << i;
      EXPECT_FALSE(motion.at(0).moving);
      EXPECT_FALSE(motion.at(10).moving);
    }
  }
}

TEST(ObjectMotion, ParkedObjectWithTooConfidentCovariancesStandsStill) {
  ObjectMotion motion({});
  Path path(0.03);
  for (int i = 0; i < 40; ++i) {
    MotionSample sample = path.sample(i * kFrame_s, {4.0, 1.0, 12.0});
    sample.position_covariance *= 0.01;
    motion.push(sample);
    EXPECT_TRUE(i < 4 || !motion.at(0).moving) << i << ": too early to see the scatter";
  }
}

TEST(ObjectMotion, SureLateralMotionCountsThoughDepthIsUncertain) {
  ObjectMotion motion({});
  Path path(0.0);
  std::mt19937 random(3);
  std::normal_distribution<double> gauss;
  for (int i = 0; i < 6; ++i) {
    MotionSample sample = path.sample(i * kFrame_s, {1.0 * i * kFrame_s, 0.0, 40.0 + 0.5 * gauss(random)});
    sample.position_covariance = Eigen::Vector3d(0.0004, 0.0004, 0.25).asDiagonal();
    motion.push(sample);
  }
  EXPECT_TRUE(motion.at(0).moving);
}

TEST(ObjectMotion, AnUncertainDepthFromAboveLiftsNothing) {
  const Eigen::Vector3d ray = Eigen::Vector3d(0.0, 1.0, 1.0).normalized();
  const auto velocity = [&](const std::optional<Eigen::Vector3d>& vertical) {
    ObjectMotion motion({});
    motion.set_vertical(vertical);
    Path path(0.0);
    for (int i = 0; i < 5; ++i) {
      const double time_s = i * kFrame_s;
      MotionSample sample = path.sample(time_s, Eigen::Vector3d(5.0 * time_s, 0.0, 0.0) - 4.0 * time_s * ray);
      sample.position_covariance = 0.0004 * Eigen::Matrix3d::Identity() + 4.0 * ray * ray.transpose();
      motion.push(sample);
    }
    return motion.at(0).velocity_mps;
  };
  EXPECT_GT(std::abs(velocity(std::nullopt).y()), 2.0);
  EXPECT_LT(std::abs(velocity(Eigen::Vector3d::UnitY()).y()), 0.7);
  EXPECT_NEAR(velocity(Eigen::Vector3d::UnitY()).x(), 5.0, 0.1);
}

TEST(ObjectMotion, CovarianceMatchesTheScatterOfVelocities) {
  const Eigen::Vector3d velocity(4.0, 0.0, -2.0);
  const Eigen::Vector3d sigma_m(0.05, 0.03, 0.2);
  std::mt19937 random(8);
  std::normal_distribution<double> gauss;
  constexpr int kTrials = 400;
  double normalised = 0.0;
  for (int trial = 0; trial < kTrials; ++trial) {
    ObjectMotion motion({});
    for (int i = 0; i < 11; ++i) {
      MotionSample sample;
      sample.timestamp_ns = i * kFrame_ns;
      sample.T_world_obj.translation =
          velocity * (i * kFrame_s) +
          Eigen::Vector3d(sigma_m.x() * gauss(random), sigma_m.y() * gauss(random), sigma_m.z() * gauss(random));
      sample.position_covariance = sigma_m.cwiseAbs2().asDiagonal();
      motion.push(sample);
    }
    const MotionEstimate estimate = motion.at(5);
    const Eigen::Vector3d error = estimate.velocity_mps - velocity;
    normalised += error.dot(estimate.covariance.ldlt().solve(error)) / (3.0 * kTrials);
  }
  // Somewhat below one: a floor is added for errors that the scatter does not show.
  EXPECT_GT(normalised, 0.4);
  EXPECT_LT(normalised, 1.1);
}

TEST(ObjectMotion, RespectsGapsAndIrregularTimes) {
  ObjectMotion motion({});
  Path path(0.01);
  const Eigen::Vector3d velocity(0.0, 0.0, 8.0);
  for (const double time_s : {0.0, 0.1, 0.4, 0.55, 0.9, 1.0}) {
    motion.push(path.sample(time_s, velocity * time_s));
  }
  EXPECT_LT((motion.at(0).velocity_mps - velocity).norm(), 0.2);
  // Samples long before a gap carry no information.
  motion.push(path.sample(60.0, {0.0, 0.0, 100.0}));
  EXPECT_FALSE(motion.at(0).moving);
}

TEST(ObjectMotion, EqualTimesDoNotMakeAVelocity) {
  ObjectMotion motion({});
  Path path(0.01);
  for (int i = 0; i < 5; ++i) {
    motion.push(path.sample(1.0, {0.1 * i, 0.0, 5.0}));
  }
  EXPECT_TRUE(motion.at(0).velocity_mps.allFinite());
  EXPECT_FALSE(motion.at(0).moving);
}

TEST(ObjectMotion, FollowsBrakingInTheMiddleOfTheWindow) {
  ObjectMotion motion({});
  Path path(0.01);
  const auto position = [](double t) { return Eigen::Vector3d(0.0, 0.0, 10.0 * t - 2.5 * t * t); };
  for (int i = 0; i < 20; ++i) {
    motion.push(path.sample(i * kFrame_s, position(i * kFrame_s)));
  }
  EXPECT_NEAR(motion.at(7).velocity_mps.z(), 10.0 - 5.0 * 1.2, 0.15);
}

TEST(ObjectMotion, StopsWithHysteresis) {
  TrajectoryConfig config;
  config.min_moving_speed_mps = 0.3;
  ObjectMotion motion(config);
  Path path(0.005);
  double z = 0.0;
  int i = 0;
  for (; i < 10; ++i) {
    motion.push(path.sample(i * kFrame_s, {0.0, 0.0, z += 0.2}));
  }
  EXPECT_TRUE(motion.at(0).moving);
  for (; i < 20; ++i) {
    motion.push(path.sample(i * kFrame_s, {0.0, 0.0, z}));
  }
  EXPECT_FALSE(motion.at(0).moving);
}

TEST(ObjectMotion, WhatMovedStaysMovingAtSignificanceThatWouldNotStartIt) {
  // With 5 cm positions, six frames give the velocity to .12 m/s: 2 m/s is sure, .4 m/s is three sigmas.
  TrajectoryConfig config;
  config.min_moving_speed_mps = 0.3;
  const auto push_slow = [](ObjectMotion& motion, int first, double start_z) {
    for (int i = 0; i < 6; ++i) {
      MotionSample sample;
      sample.timestamp_ns = (first + i) * kFrame_ns;
      sample.T_world_obj.translation.z() = start_z + 0.04 * i;
      sample.position_covariance = 0.0025 * Eigen::Matrix3d::Identity();
      motion.push(sample);
    }
  };
  ObjectMotion slow_from_birth(config);
  push_slow(slow_from_birth, 0, 0.0);
  EXPECT_FALSE(slow_from_birth.at(0).moving);
  ObjectMotion slowed_down(config);
  for (int i = 0; i < 10; ++i) {
    MotionSample sample;
    sample.timestamp_ns = i * kFrame_ns;
    sample.T_world_obj.translation.z() = 0.2 * i;
    sample.position_covariance = 0.0025 * Eigen::Matrix3d::Identity();
    slowed_down.push(sample);
  }
  push_slow(slowed_down, 10, 1.84);
  EXPECT_TRUE(slowed_down.at(0).moving);
}

/// `count` exact samples of a steady motion, each of which may be off by `correlated_error_m` along every axis.
void push_correlated(ObjectMotion& motion, const Eigen::Vector3d& velocity_mps,
                     const Eigen::Vector3d& correlated_error_m, int count, double step_s, double start_s = 0.0) {
  for (int i = 0; i < count; ++i) {
    MotionSample sample;
    sample.timestamp_ns = static_cast<std::int64_t>(1e9 * (start_s + i * step_s));
    sample.T_world_obj.translation = velocity_mps * (i * step_s);
    sample.position_covariance = 1e-6 * Eigen::Matrix3d::Identity();
    sample.correlated_covariance = correlated_error_m.cwiseAbs2().asDiagonal();
    motion.push(sample);
  }
}

/// Whether such a motion counts as moving, with a threshold of .1 m/s.
bool moves(const Eigen::Vector3d& velocity_mps, const Eigen::Vector3d& correlated_error_m, int count, double step_s,
           bool walks = false) {
  TrajectoryConfig config;
  config.min_moving_speed_mps = 0.1;
  ObjectMotion motion(config);
  motion.set_gait(walks);
  push_correlated(motion, velocity_mps, correlated_error_m, count, step_s);
  return motion.at(0).moving;
}

TEST(ObjectMotion, MotionWithinTheCorrelatedErrorDoesNotCountAndFasterDoes) {
  // A tenth of a metre over the half second of the window: .2 m/s, and four times that shows a motion.
  const Eigen::Vector3d correlated_error_m(0.0, 0.0, 0.1);
  EXPECT_TRUE(moves({0.0, 0.0, 0.6}, Eigen::Vector3d::Zero(), 6, kFrame_s));
  EXPECT_FALSE(moves({0.0, 0.0, 0.6}, correlated_error_m, 6, kFrame_s));
  EXPECT_TRUE(moves({0.0, 0.0, 1.2}, correlated_error_m, 6, kFrame_s));
  EXPECT_TRUE(moves({0.6, 0.0, 0.0}, correlated_error_m, 6, kFrame_s)) << "across what drifts";
}

TEST(ObjectMotion, ACorrelatedErrorTakesHalfASecond) {
  const Eigen::Vector3d correlated_error_m(0.0, 0.0, 0.1);
  for (const double step_s : {0.05, 0.1}) {
    EXPECT_TRUE(moves({0.0, 0.0, 1.2}, correlated_error_m, 3, step_s)) << step_s;
    EXPECT_FALSE(moves({0.0, 0.0, 0.6}, correlated_error_m, 3, step_s)) << step_s;
  }
  // Over a whole second, as of a person, it would have to go twice as far.
  EXPECT_TRUE(moves({0.0, 0.0, 0.6}, correlated_error_m, 6, 2.0 * kFrame_s, true));
}

TEST(ObjectMotion, ObservationsLongBeforeAGapGiveTheErrorNoTime) {
  TrajectoryConfig config;
  config.min_moving_speed_mps = 0.1;
  ObjectMotion motion(config);
  const Eigen::Vector3d correlated_error_m(0.0, 0.0, 0.1);
  push_correlated(motion, Eigen::Vector3d::Zero(), correlated_error_m, 3, kFrame_s);
  push_correlated(motion, {0.0, 0.0, 0.6}, correlated_error_m, 3, kFrame_s, 60.0);
  EXPECT_FALSE(motion.at(0).moving);
}

// A person 9 m from glasses, who walks towards them: the depth is uncertain by .3 m.
TEST(ObjectMotion, IsMeasuredOverTimeNotOverFrames) {
  const auto significance = [](double frame_s) {
    ObjectMotion motion({});
    Path path(0.0);
    for (int i = 0; i * frame_s < 1.5; ++i) {
      MotionSample sample = path.sample(i * frame_s, {0.0, 0.0, 9.0 - 1.1 * i * frame_s});
      sample.position_covariance = 0.3 * 0.3 * Eigen::Matrix3d::Identity();
      motion.push(sample);
    }
    return std::sqrt(motion.at(0).covariance(2, 2));
  };
  EXPECT_LT(significance(0.04), significance(0.1));
  EXPECT_GT(significance(0.04), 0.4 * significance(0.1));
}

TEST(ObjectMotion, PeopleAreMeasuredOverTwiceTheTime) {
  const auto sigma_mps = [](bool walks) {
    ObjectMotion motion({});
    motion.set_gait(walks);
    Path path(0.2);
    for (int i = 0; i < 20; ++i) {
      motion.push(path.sample(0.1 * i, {0.0, 0.0, 9.0 - 0.11 * i}));
    }
    return std::sqrt(motion.at(0).covariance(2, 2));
  };
  EXPECT_LT(sigma_mps(true), 0.6 * sigma_mps(false));
}

/// Whether a walk at 1 m/s counts as moving whose visible part may drift by half a metre, of which segmentation has
/// found `detected` of the ten samples moving.
bool walk_moves(int detected, double speed_mps = 1.0) {
  ObjectMotion motion({});
  for (int i = 0; i < 10; ++i) {
    MotionSample sample;
    sample.timestamp_ns = i * kFrame_ns;
    sample.T_world_obj.translation.x() = speed_mps * kFrame_s * i;
    sample.position_covariance = 1e-4 * Eigen::Matrix3d::Identity();
    sample.part_drift_covariance = 0.25 * Eigen::Matrix3d::Identity();
    sample.detected_moving = i % 10 < detected;
    motion.push(sample);
  }
  const MotionEstimate estimate = motion.at(4);
  EXPECT_FALSE(estimate.moving_by_path);
  EXPECT_GT(estimate.covariance(0, 0), 0.2) << "may have drifted, by the path";
  return estimate.moving;
}

TEST(ObjectMotion, WhatSegmentationFoundMovingInMostFramesIsNoDriftOfItsVisiblePart) {
  EXPECT_TRUE(walk_moves(10));
  EXPECT_TRUE(walk_moves(6));
}

TEST(ObjectMotion, SegmentationAloneMovesNothing) {
  EXPECT_FALSE(walk_moves(0)) << "a drift, perhaps";
  EXPECT_FALSE(walk_moves(4)) << "found in few frames: an outlier";
  EXPECT_FALSE(walk_moves(10, 0.1)) << "its path does not move";
}

TEST(ObjectMotion, APredictedPositionIsNoEvidence) {
  ObjectMotion motion({});
  Path path(0.01);
  for (int i = 0; i < 8; ++i) {
    MotionSample sample = path.sample(0.1 * i, {0.1 * i, 0.0, 9.0});
    if (i % 3 == 1) {  // predicted, far off
      sample.T_world_obj.translation.x() += 30.0;
      sample.is_evidence = false;
    }
    motion.push(sample);
  }
  const MotionEstimate estimate = motion.at(0);
  EXPECT_TRUE(estimate.moving);
  EXPECT_NEAR(estimate.velocity_mps.x(), 1.0, 0.1);
}

TEST(ObjectMotion, FollowsTheReferencePointAndTheTurn) {
  ObjectMotion motion({});
  Path path(0.001);
  constexpr double kRate = 0.5;
  // The object's origin stands still; a point 4 m ahead of it sweeps round.
  for (int i = 0; i < 11; ++i) {
    motion.push(path.sample(i * kFrame_s, {0.0, 0.0, 20.0}, kRate * (i - 5) * kFrame_s));
  }
  EXPECT_LT(motion.at(5).velocity_mps.norm(), 0.05);
  motion.set_reference({4.0, 0.0, 0.0});
  const MotionEstimate estimate = motion.at(5);
  EXPECT_NEAR(estimate.velocity_mps.z(), -4.0 * kRate, 0.1) << "rotation_y turns x towards -z";
  EXPECT_NEAR(estimate.yaw_rate_rad_s, kRate, 1e-3);
}

TEST(ObjectMotion, ReviseReplacesAPastPose) {
  ObjectMotion motion({});
  Path path(0.0);
  for (int i = 0; i < 6; ++i) {
    motion.push(path.sample(i * kFrame_s, {0.0, 0.0, i == 3 ? 9.0 : 0.5 * i}));
  }
  motion.revise(2, {Eigen::Matrix3d::Identity(), {0.0, 0.0, 1.5}}, 1e-6 * Eigen::Matrix3d::Identity());
  motion.revise(6, {Eigen::Matrix3d::Identity(), {0.0, 0.0, 99.0}}, Eigen::Matrix3d::Identity());
  EXPECT_NEAR(motion.at(2).velocity_mps.z(), 5.0, 1e-3);
}

TEST(ObjectMotion, KeepsTheNewestAtCapacityAndForgetsAtReset) {
  ObjectMotion motion({});
  Path path(0.001);
  for (std::size_t i = 0; i < ObjectMotion::kCapacity + 1; ++i) {
    motion.push(path.sample(static_cast<double>(i) * kFrame_s, {static_cast<double>(i) * 0.3, 0.0, 0.0}));
    EXPECT_EQ(motion.size(), std::min(i + 1, ObjectMotion::kCapacity));
  }
  EXPECT_NEAR(motion.at(0).velocity_mps.x(), 3.0, 0.1);
  EXPECT_NEAR(motion.at(ObjectMotion::kCapacity - 1).velocity_mps.x(), 3.0, 0.1);
  EXPECT_TRUE(motion.at(ObjectMotion::kCapacity).velocity_mps.isZero());
  motion.reset();
  EXPECT_EQ(motion.size(), 0U);
  motion.push(path.sample(100.0, {0.0, 0.0, 0.0}));
  EXPECT_FALSE(motion.at(0).moving);
}

TEST(ObjectMotion, DoesNotAllocate) {
  if (!allocation_counting_available()) {
    GTEST_SKIP() << "allocations are not counted in this build";
  }
  ObjectMotion motion({});
  Path path(0.01);
  const std::uint64_t before = allocation_counts().own;
  for (int i = 0; i < 20; ++i) {
    motion.push(path.sample(i * kFrame_s, {0.1 * i, 0.0, 0.0}));
    (void)motion.at(5);
  }
  EXPECT_EQ(allocation_counts().own - before, 0U);
}

}  // namespace
}  // namespace kinetrace::trajectory
