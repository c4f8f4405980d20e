#include "kinetrace/trajectory/trajectory_smoother.hpp"

#include <cmath>
#include <random>
#include <vector>

#include <gtest/gtest.h>

namespace kinetrace::trajectory {
namespace {

constexpr double kStep_s = 0.1;
constexpr double kSigma_m = 0.05;
constexpr double kSigma_rad = 0.01;

/// A vehicle that turns at a constant rate: constant velocity in its own axes.
Se3 turning(double time_s) {
  const double yaw = 0.4 * time_s;
  return {so3_exp({0.0, yaw, 0.0}), {10.0 * std::sin(yaw), 0.0, 10.0 * std::cos(yaw)}};
}

Matrix6d covariance(double sigma_rad, double sigma_m) {
  Vector6d variance;
  variance << Eigen::Vector3d::Constant(sigma_rad * sigma_rad), Eigen::Vector3d::Constant(sigma_m * sigma_m);
  return variance.asDiagonal();
}

std::vector<PathNode> path(std::size_t count) {
  std::vector<PathNode> nodes(count);
  for (std::size_t k = 0; k < count; ++k) {
    const double time_s = kStep_s * static_cast<double>(k);
    nodes[k] = {static_cast<std::int64_t>(std::llround(1e9 * time_s)), turning(time_s),
                covariance(kSigma_rad, kSigma_m), Se3{}};
  }
  return nodes;
}

void disturb(std::vector<PathNode>& nodes, unsigned seed) {
  std::mt19937 engine(seed);
  std::normal_distribution<double> unit;
  for (PathNode& node : nodes) {
    node.measured.rotation =
        so3_exp(kSigma_rad * Eigen::Vector3d(unit(engine), unit(engine), unit(engine))) * node.measured.rotation;
    node.measured.translation += kSigma_m * Eigen::Vector3d(unit(engine), unit(engine), unit(engine));
  }
}

struct StepError {
  double metres = 0.0;
  double radians = 0.0;
};

/// Mean error of the motion between neighbours.
template <typename Pose>
StepError step_error(const std::vector<PathNode>& nodes, Pose&& pose) {
  StepError error;
  for (std::size_t k = 1; k < nodes.size(); ++k) {
    const Se3 truth =
        turning(kStep_s * static_cast<double>(k - 1)).inverse() * turning(kStep_s * static_cast<double>(k));
    const Se3 off = truth.inverse() * (pose(nodes[k - 1]).inverse() * pose(nodes[k]));
    error.metres += off.translation.norm() / static_cast<double>(nodes.size() - 1);
    error.radians += so3_log(off.rotation).norm() / static_cast<double>(nodes.size() - 1);
  }
  return error;
}

class TrajectorySmootherTest : public ::testing::Test {
 protected:
  static constexpr std::size_t kMaxNodes = 13;
  Arena arena_{std::size_t{1} << 16};
  TrajectorySmoother smoother_{TrajectoryConfig{}, kMaxNodes, arena_};
};

// But for the prior of the first velocity.
TEST_F(TrajectorySmootherTest, LeavesAPathOfConstantBodyVelocityAsItIs) {
  std::vector<PathNode> nodes = path(kMaxNodes);
  smoother_.smooth(nodes, 0);
  for (std::size_t k = 0; k < nodes.size(); ++k) {
    const Se3 truth = turning(kStep_s * static_cast<double>(k));
    EXPECT_LT((nodes[k].smoothed.translation - truth.translation).norm(), 1e-4) << k;
    EXPECT_LT((nodes[k].smoothed.rotation - truth.rotation).norm(), 1e-6) << k;
  }
}

TEST_F(TrajectorySmootherTest, ReducesTheErrorOfNoisyMotionSeveralTimes) {
  StepError before;
  StepError after;
  for (unsigned seed = 0; seed < 20; ++seed) {
    std::vector<PathNode> nodes = path(kMaxNodes);
    disturb(nodes, seed);
    smoother_.smooth(nodes, 0);
    const StepError raw = step_error(nodes, [](const PathNode& n) { return n.measured; });
    const StepError smooth = step_error(nodes, [](const PathNode& n) { return n.smoothed; });
    before = {before.metres + raw.metres, before.radians + raw.radians};
    after = {after.metres + smooth.metres, after.radians + smooth.radians};
  }
  EXPECT_LT(after.metres, before.metres / 3.0);
  EXPECT_LT(after.radians, before.radians / 2.0);
}

TEST_F(TrajectorySmootherTest, NeitherLeavesTheGroundNorTiltsByNoise) {
  const Eigen::Vector3d vertical = Eigen::Vector3d::UnitY();
  const auto squares = [&](const PathPrior& prior) {
    double lift = 0.0;
    double tilt = 0.0;
    for (unsigned seed = 0; seed < 20; ++seed) {
      std::vector<PathNode> nodes = path(kMaxNodes);
      disturb(nodes, seed);
      smoother_.smooth(nodes, 0, prior);
      for (std::size_t k = 1; k < nodes.size(); ++k) {
        const Eigen::Vector3d way = nodes[k].smoothed.translation - nodes[k - 1].smoothed.translation;
        lift += std::pow(vertical.dot(way), 2);
        tilt += std::pow((nodes[k].smoothed.rotation * vertical - nodes[k - 1].smoothed.rotation * vertical).norm(), 2);
      }
    }
    return std::array{lift, tilt};
  };
  const auto [lift, tilt] = squares({.vertical = vertical});
  const auto [free_lift, free_tilt] = squares({});
  EXPECT_LT(lift, 0.5 * free_lift);
  EXPECT_LT(tilt, 0.5 * free_tilt);
}

/// An object that is followed by the middle of its visible part, several metres before its origin.
TEST_F(TrajectorySmootherTest, ARotationThatWasNeverMeasuredLeavesThePathAsItWasMeasured) {
  std::vector<PathNode> nodes(6);
  const Eigen::Matrix3d lever = skew(Eigen::Vector3d(3.0, 1.0, 4.0));
  for (std::size_t k = 0; k < nodes.size(); ++k) {
    const double time_s = kStep_s * static_cast<double>(k);
    nodes[k] = {static_cast<std::int64_t>(std::llround(1e9 * time_s)),
                Se3{Eigen::Matrix3d::Identity(), {5.0 * time_s, 0.0, 20.0}}, covariance(1.5, 0.1), Se3{}};
    const Eigen::Matrix3d of_rotation = nodes[k].covariance.topLeftCorner<3, 3>();
    nodes[k].covariance.topRightCorner<3, 3>() = of_rotation * lever.transpose();
    nodes[k].covariance.bottomLeftCorner<3, 3>() = lever * of_rotation;
    nodes[k].covariance.bottomRightCorner<3, 3>() += lever * of_rotation * lever.transpose();
  }
  smoother_.smooth(nodes, 0);
  for (const PathNode& node : nodes) {
    EXPECT_LT((node.smoothed.translation - node.measured.translation).norm(), 0.01);
    EXPECT_LT((node.smoothed.rotation - node.measured.rotation).norm(), 1e-3);
  }
}

/// A short path along x, whose error of depth, along the ray of a camera that looks down by 45 degrees, grows.
TEST_F(TrajectorySmootherTest, AnUncertainDepthFromAboveLiftsNothing) {
  const Eigen::Vector3d ray = Eigen::Vector3d(0.0, 1.0, 1.0).normalized();
  const auto lift_mps = [&](const PathPrior& prior) {
    std::vector<PathNode> nodes(5);
    for (std::size_t k = 0; k < nodes.size(); ++k) {
      const double time_s = kStep_s * static_cast<double>(k);
      nodes[k] = {static_cast<std::int64_t>(std::llround(1e9 * time_s)),
                  Se3{Eigen::Matrix3d::Identity(), Eigen::Vector3d(5.0 * time_s, 0.0, 0.0) - 4.0 * time_s * ray},
                  covariance(0.01, 0.02), Se3{}};
      nodes[k].covariance.bottomRightCorner<3, 3>() += 4.0 * ray * ray.transpose();
    }
    smoother_.smooth(nodes, 0, prior);
    const Vector6d velocity = body_velocity(nodes.front(), nodes.back());
    EXPECT_NEAR(velocity[3], 5.0, 0.1);
    return std::abs((nodes.front().smoothed.rotation * velocity.tail<3>()).y());
  };
  EXPECT_GT(lift_mps({}), 2.0);
  EXPECT_LT(lift_mps({.vertical = Eigen::Vector3d::UnitY()}), 0.7);
}

TEST_F(TrajectorySmootherTest, AcceptsGoodMeasurementsOfABrakingVehicle) {
  std::vector<PathNode> nodes(kMaxNodes);
  const auto place = [](double time_s) { return 10.0 * time_s - 0.5 * 6.0 * time_s * time_s; };
  for (std::size_t k = 0; k < nodes.size(); ++k) {
    const double time_s = kStep_s * static_cast<double>(k);
    nodes[k] = {static_cast<std::int64_t>(std::llround(1e9 * time_s)),
                Se3{Eigen::Matrix3d::Identity(), {place(time_s), 0.0, 0.0}}, covariance(0.001, 0.005), Se3{}};
  }
  smoother_.smooth(nodes, 0);
  for (const PathNode& node : nodes) {
    EXPECT_NEAR(node.smoothed.translation.x(), node.measured.translation.x(), 0.005);
  }
}

// An impossibly sudden reversal. With twice as many frames, each has twice the variance.
TEST_F(TrajectorySmootherTest, SmoothsAlikeAtEveryRateOfTheCamera) {
  constexpr double kTurnsRound_s = 0.6;
  const auto rounded_m = [](double rate_hz) {
    const auto turns_round = static_cast<std::size_t>(std::lround(kTurnsRound_s * rate_hz));
    std::vector<PathNode> nodes(2 * turns_round + 1);
    for (std::size_t k = 0; k < nodes.size(); ++k) {
      const double time_s = static_cast<double>(k) / rate_hz;
      nodes[k].timestamp_ns = std::llround(1e9 * time_s);
      nodes[k].measured.translation.x() = std::abs(time_s - kTurnsRound_s);
      nodes[k].covariance = rate_hz * covariance(0.03, 0.03);
    }
    Arena arena(std::size_t{1} << 17);
    TrajectorySmoother(TrajectoryConfig{}, nodes.size(), arena).smooth(nodes, 0);
    return nodes[turns_round].smoothed.translation.x();
  };
  EXPECT_GT(rounded_m(10), 0.1);
  EXPECT_NEAR(rounded_m(20), rounded_m(10), 0.01);
  EXPECT_NEAR(rounded_m(30), rounded_m(10), 0.01);
}

TEST_F(TrajectorySmootherTest, IsNotBentByOneWildPosition) {
  std::vector<PathNode> nodes = path(kMaxNodes);
  nodes[6].measured.translation += Eigen::Vector3d(0.0, 0.0, 4.0);
  smoother_.smooth(nodes, 0);
  for (std::size_t k = 0; k < nodes.size(); ++k) {
    EXPECT_LT((nodes[k].smoothed.translation - turning(kStep_s * static_cast<double>(k)).translation).norm(), 0.1) << k;
  }
}

TEST_F(TrajectorySmootherTest, KeepsFinalNodesAndContinuesFromThem) {
  std::vector<PathNode> nodes = path(kMaxNodes);
  disturb(nodes, 7);
  for (std::size_t k = 0; k < 2; ++k) {
    nodes[k].smoothed = turning(kStep_s * static_cast<double>(k));
  }
  smoother_.smooth(nodes, 2);
  EXPECT_EQ(nodes[0].smoothed.translation, turning(0.0).translation);
  EXPECT_EQ(nodes[1].smoothed.translation, turning(kStep_s).translation);
  EXPECT_LT((nodes[2].smoothed.translation - turning(2 * kStep_s).translation).norm(), 0.03);
}

TEST_F(TrajectorySmootherTest, HardlyMovesTwoCertainPoses) {
  for (std::size_t count : {std::size_t{0}, std::size_t{1}, std::size_t{2}}) {
    std::vector<PathNode> nodes = path(count);
    disturb(nodes, 3);
    smoother_.smooth(nodes, 0);
    for (const PathNode& node : nodes) {
      EXPECT_LT((node.smoothed.translation - node.measured.translation).norm(), 0.1 * kSigma_m);
    }
  }
}

// A far object whose depth is known to 15 m in both frames does not move at 150 m/s.
TEST_F(TrajectorySmootherTest, RejectsASpeedThatErrorsOfDepthExplain) {
  std::vector<PathNode> nodes = path(2);
  nodes[0].measured = {Eigen::Matrix3d::Identity(), {0.0, 0.0, 105.0}};
  nodes[1].measured = {Eigen::Matrix3d::Identity(), {0.0, 0.0, 90.0}};
  for (PathNode& node : nodes) {
    node.covariance = covariance(kSigma_rad, 0.3);
    node.covariance(5, 5) = 15.0 * 15.0;
  }
  smoother_.smooth(nodes, 0);
  EXPECT_LT(body_velocity(nodes[0], nodes[1]).tail<3>().norm(), 10.0);
}

TEST_F(TrajectorySmootherTest, DoesNotTurnWhatWasNeverSeenToTurn) {
  std::vector<PathNode> nodes = path(kMaxNodes);
  for (PathNode& node : nodes) {
    node.measured.rotation = Eigen::Matrix3d::Identity();
    node.covariance = covariance(1.0, 0.2);
  }
  smoother_.smooth(nodes, 0);
  for (const PathNode& node : nodes) {
    EXPECT_LT(so3_log(node.smoothed.rotation).norm(), 1e-3);
  }
}

TEST_F(TrajectorySmootherTest, HoldsWhatIsAtRest) {
  std::mt19937 engine(5);
  std::normal_distribution<double> unit;
  std::vector<PathNode> nodes = path(kMaxNodes);
  for (PathNode& node : nodes) {
    node.measured = {Eigen::Matrix3d::Identity(), kSigma_m * Eigen::Vector3d(unit(engine), unit(engine), unit(engine))};
  }
  const auto path_length_m = [&](bool at_rest) {
    smoother_.smooth(nodes, 0, {.at_rest = at_rest});
    double length_m = 0.0;
    for (std::size_t k = 1; k < nodes.size(); ++k) {
      length_m += (nodes[k].smoothed.translation - nodes[k - 1].smoothed.translation).norm();
    }
    return length_m;
  };
  EXPECT_LT(path_length_m(true), 0.3 * path_length_m(false));
}

TEST_F(TrajectorySmootherTest, FillsAGapWhereThePathLeadsThroughIt) {
  std::vector<PathNode> nodes = path(kMaxNodes);
  for (std::size_t k = 5; k < 8; ++k) {
    nodes[k].measured.translation += Eigen::Vector3d(0.6, 0.0, -0.6);
    nodes[k].covariance = covariance(1.0, 1.0);
  }
  smoother_.smooth(nodes, 0);
  for (std::size_t k = 5; k < 8; ++k) {
    EXPECT_LT((nodes[k].smoothed.translation - turning(kStep_s * static_cast<double>(k)).translation).norm(), 0.03);
  }
}

}  // namespace
}  // namespace kinetrace::trajectory
