// A path fitted to a receiver: removes drift without adding the receiver's noise.
#include "reference/reference_fit.hpp"

#include <cmath>
#include <random>

#include <gtest/gtest.h>

#include "alignment_model.hpp"
#include "receiver.hpp"

namespace kinetrace::batch {
namespace {

using geo::PathPose;
using geo::test::any_placement;
using geo::test::drive;
using geo::test::receive;
using geo::test::Receiver;
using geo::test::town;

const AdjustmentOptions kOptions{.threads = 1, .keep_going = [] { return true; }};

/// Odometry on a path: each step has noise of known size.
struct Odometry {
  double rotation_rad = 0.0;  ///< Per step.
  double position_m = 0.0;

  [[nodiscard]] Matrix6d information() const {
    Vector6d weights;
    weights << Eigen::Vector3d::Constant(1.0 / (rotation_rad * rotation_rad)),
        Eigen::Vector3d::Constant(1.0 / (position_m * position_m));
    return weights.asDiagonal();
  }
};

class ReferenceFitTest : public ::testing::Test {
 protected:
  void travel(const std::vector<PathPose>& truth, const Odometry& odometry, unsigned seed) {
    std::mt19937 random(seed);
    std::normal_distribution<double> normal;
    truth_ = truth;
    run_ = {};
    run_.rectified = {400.0, 400.0, 319.5, 119.5, 0.5, 640, 240};
    graph_.T_world_cam.clear();
    for (std::size_t row = 0; row < truth.size(); ++row) {
      run_.camera.push_back({static_cast<std::int64_t>(row), truth[row].time_ns, {}});
      Vector6d error;
      for (Eigen::Index i = 0; i < 6; ++i) {
        error[i] = (i < 3 ? odometry.rotation_rad : odometry.position_m) * normal(random);
      }
      graph_.T_world_cam.push_back(
          row == 0 ? truth[0].T_world_cam
                   : graph_.T_world_cam.back() *
                         left_update(truth[row - 1].T_world_cam.inverse() * truth[row].T_world_cam, error));
    }
    graph_.step_information.assign(truth.size(), odometry.information());
    camera_.T_world_cam = graph_.T_world_cam;
  }
  Result<ReferenceFit> fit(const Receiver& receiver, unsigned seed) {
    std::mt19937 random(seed);
    geo::AlignmentConfig config{.freedom = geo::Freedom::kYaw, .lever_arm_m = receiver.lever_arm_m};
    return fit_to_reference(run_, receive(truth_, receiver, random), config, graph_, kOptions, camera_);
  }
  /// RMS position error on the map, with the alignment of noise-free fixes.
  [[nodiscard]] double error_m() const {
    std::vector<PathPose> path = truth_;
    std::vector<geo::Fix> fixes;
    for (std::size_t row = 0; row < path.size(); ++row) {
      path[row].T_world_cam = camera_.T_world_cam[row];
      fixes.push_back({truth_[row].time_ns, geo::level_rotation() * truth_[row].T_world_cam.translation});
    }
    const auto aligned = geo::align(path, fixes, {.max_time_offset_s = 0.0});
    double sum = 0.0;
    for (std::size_t row = 0; row < path.size(); ++row) {
      sum += (aligned->T_map_world * path[row].T_world_cam.translation - fixes[row].enu_m).squaredNorm();
    }
    return std::sqrt(sum / static_cast<double>(path.size()));
  }

  std::vector<PathPose> truth_;
  recording::Run run_;
  PathGraph graph_;
  RefinedCamera camera_;
};

TEST_F(ReferenceFitTest, TakesOutWhatThePathHasDrifted) {
  geo::test::PathShape shape = town();
  shape.length_m = 600.0;
  travel(drive(shape), {.rotation_rad = 2e-3, .position_m = 0.01}, 3);
  std::mt19937 random(4);
  const Receiver receiver{.T_map_world = any_placement(random, 0.0),
                          .lever_arm_m = {0.3, -1.2, -0.5},
                          .time_offset_s = 0.4,
                          .noise_m = 0.3,
                          .outlier_share = 0.1};
  const double before_m = error_m();
  ASSERT_GT(before_m, 1.0);
  const auto fitted = fit(receiver, 5);
  ASSERT_TRUE(fitted) << fitted.error().message;
  EXPECT_LT(error_m(), 0.15 * before_m);
  EXPECT_GT(fitted->moved_m, 1.0);
  EXPECT_NEAR(fitted->alignment.horizontal_noise_m, receiver.noise_m, 0.1 * receiver.noise_m);
  EXPECT_NEAR(fitted->alignment.time_offset_s, receiver.time_offset_s, 0.02);
}

TEST_F(ReferenceFitTest, BringsInNoNoiseOfTheReceiver) {
  travel(drive(town()), {.rotation_rad = 2e-5, .position_m = 0.001}, 6);
  std::mt19937 random(7);
  const Receiver receiver{.T_map_world = any_placement(random, 0.0), .noise_m = 1.5, .correlation = 0.95};
  const auto fitted = fit(receiver, 8);
  ASSERT_TRUE(fitted) << fitted.error().message;
  EXPECT_NEAR(fitted->scale, 1.0, 0.002);
  EXPECT_LT(error_m(), 0.1 * receiver.noise_m);
}

TEST_F(ReferenceFitTest, FindsThatTheBaselineWasTooShort) {
  travel(drive(town()), {.rotation_rad = 2e-5, .position_m = 0.001}, 15);
  for (Se3& T_world_cam : graph_.T_world_cam) {
    T_world_cam.translation *= 0.99;
  }
  camera_.T_world_cam = graph_.T_world_cam;
  RefinedPoint point;
  point.position_m = camera_.T_world_cam[0] * Eigen::Vector3d(0.0, 0.0, 9.9);
  camera_.points = {point};
  std::mt19937 random(16);
  const auto fitted = fit({.T_map_world = any_placement(random, 0.0), .noise_m = 0.1}, 17);
  ASSERT_TRUE(fitted) << fitted.error().message;
  EXPECT_NEAR(fitted->scale, 1.0 / 0.99, 0.001);
  EXPECT_LT(error_m(), 0.1);
  EXPECT_NEAR(camera_.points[0].position_m.z(), 10.0, 0.01);
}

TEST_F(ReferenceFitTest, PointsGoAlong) {
  travel(drive(town()), {.rotation_rad = 2e-3, .position_m = 0.01}, 9);
  const std::uint32_t row = 250;
  const Eigen::Vector3d seen_m(1.0, 0.5, 12.0);
  RefinedPoint point;
  point.position_m = camera_.T_world_cam[row] * seen_m;
  point.last_frame = row;
  camera_.points.push_back(point);
  std::mt19937 random(10);
  const auto fitted = fit({.T_map_world = any_placement(random, 0.0), .noise_m = 0.1}, 11);
  ASSERT_TRUE(fitted) << fitted.error().message;
  EXPECT_NE(camera_.T_world_cam[row].translation, graph_.T_world_cam[row].translation);
  const Eigen::Vector3d now_m = camera_.T_world_cam[row].inverse() * camera_.points[0].position_m;
  EXPECT_LT((now_m - fitted->scale * seen_m).norm(), 1e-9);
}

TEST_F(ReferenceFitTest, RefusesAReceiverThatStandsStillOrScalesThePath) {
  travel(drive({.length_m = 20.0}), {.rotation_rad = 2e-5, .position_m = 0.001}, 18);
  std::mt19937 random(19);
  const auto fixes = receive(truth_, {.T_map_world = any_placement(random, 0.0), .noise_m = 0.02}, random);
  for (const double scale : {0.0, 1.3}) {
    std::vector<geo::Fix> scaled = fixes;
    for (geo::Fix& fix : scaled) {
      fix.enu_m = fixes.front().enu_m + scale * (fix.enu_m - fixes.front().enu_m);
    }
    const auto refused = fit_to_reference(run_, scaled, {.freedom = geo::Freedom::kYaw, .max_time_offset_s = 0.0},
                                          graph_, kOptions, camera_);
    ASSERT_FALSE(refused) << scale;
    EXPECT_NE(refused.error().message.find("the heading is known to"), std::string::npos) << refused.error().message;
    EXPECT_EQ(camera_.T_world_cam.back().translation, graph_.T_world_cam.back().translation);
  }
}

TEST_F(ReferenceFitTest, KeepsThePathAfterAnInterrupt) {
  travel(drive({.length_m = 20.0}), {.rotation_rad = 2e-5, .position_m = 0.001}, 18);
  std::mt19937 random(19);
  std::vector<geo::Fix> fixes = receive(truth_, {.T_map_world = any_placement(random, 0.0), .noise_m = 0.02}, random);
  for (geo::Fix& fix : fixes) {
    fix.enu_m = fixes.front().enu_m + 1.3 * (fix.enu_m - fixes.front().enu_m);
  }
  const geo::AlignmentConfig config{.freedom = geo::Freedom::kYaw, .max_time_offset_s = 0.0};
  ASSERT_FALSE(fit_to_reference(run_, fixes, config, graph_, kOptions, camera_));
  const AdjustmentOptions interrupted{.threads = 1, .keep_going = [] { return false; }};
  const auto kept = fit_to_reference(run_, fixes, config, graph_, interrupted, camera_);
  ASSERT_TRUE(kept) << kept.error().message;
  EXPECT_EQ(kept->moved_m, 0.0);
  EXPECT_EQ(kept->scale, 1.0);
  EXPECT_EQ(camera_.T_world_cam.back().translation, graph_.T_world_cam.back().translation);
}

TEST_F(ReferenceFitTest, TakesAStraightPathHoweverTheMapLiesAboutIt) {
  travel(drive({.length_m = 200.0}), {.rotation_rad = 1e-3, .position_m = 0.01}, 12);
  std::mt19937 random(13);
  std::vector<geo::Fix> fixes = receive(truth_, {.T_map_world = any_placement(random, 0.0), .noise_m = 0.2}, random);
  const auto refused = fit_to_reference(run_, fixes, {}, graph_, kOptions, camera_);
  ASSERT_FALSE(refused) << "at a constant speed nobody knows the offset of the clocks";
  EXPECT_EQ(refused.error().code, ErrorCode::kBadFormat);
  EXPECT_EQ(camera_.T_world_cam.back().translation, graph_.T_world_cam.back().translation);

  const double before_m = error_m();
  const auto fitted = fit_to_reference(run_, fixes, {.max_time_offset_s = 0.0}, graph_, kOptions, camera_);
  ASSERT_TRUE(fitted) << fitted.error().message;
  EXPECT_LT(error_m(), 0.5 * before_m);
}

}  // namespace
}  // namespace kinetrace::batch
