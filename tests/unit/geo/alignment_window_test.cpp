#include "kinetrace/geo/alignment_window.hpp"

#include <cmath>

#include <gtest/gtest.h>

#include "receiver.hpp"

namespace kinetrace::geo {
namespace {

constexpr std::int64_t kTenth_ns = 100'000'000;

AlignmentWindow make(const AlignmentWindowConfig& config) {
  return AlignmentWindow::create(config).value();
}

PathPose pose(std::int64_t time_ns, double forward_m) {
  return {time_ns, {Eigen::Matrix3d::Identity(), {0.0, 0.0, forward_m}}};
}

Fix fix(std::int64_t time_ns) {
  return {time_ns, Eigen::Vector3d::Zero(), Eigen::Vector3d::Ones()};
}

/// One metre per tenth of a second, a fix with each pose.
void drive_on(AlignmentWindow& window, int first, int count) {
  for (int i = first; i < first + count; ++i) {
    window.add(pose((i + 1) * kTenth_ns, i));
    window.add(fix((i + 1) * kTenth_ns));
  }
}

TEST(AlignmentWindow, KeepsTheNewestStretchOfThePath) {
  AlignmentWindow window = make({.max_path_m = 10.0});
  drive_on(window, 0, 11);
  EXPECT_EQ(window.path().size(), 11U) << "exactly 10 m";
  drive_on(window, 11, 1);
  ASSERT_EQ(window.path().size(), 11U);
  EXPECT_EQ(window.path().front().T_world_cam.translation.z(), 1.0);
  EXPECT_EQ(window.fixes().size(), 11U) << "the fix on the metre that was removed goes with it";
  EXPECT_EQ(window.counts().fixes_before_window, 1);
  EXPECT_EQ(window.distance_m(), 11.0);
}

TEST(AlignmentWindow, RemovesTheOldestAtCapacityAndOnePastIt) {
  AlignmentWindow window = make({.max_path_m = 1e6, .max_poses = 20, .max_fixes = 5});
  drive_on(window, 0, 5);
  EXPECT_EQ(window.counts().fixes_before_window, 0);
  const PathPose* const poses = window.path().data();
  const Fix* const fixes = window.fixes().data();
  drive_on(window, 5, 200);
  EXPECT_EQ(window.path().size(), 20U);
  ASSERT_EQ(window.fixes().size(), 5U);
  EXPECT_EQ(window.fixes().back().time_ns, 205 * kTenth_ns);
  EXPECT_EQ(window.fixes().front().time_ns, 201 * kTenth_ns);
  EXPECT_EQ(window.counts().fixes_before_window, 200);
  EXPECT_EQ(window.path().data(), poses) << "in the memory that it was made with";
  EXPECT_EQ(window.fixes().data(), fixes);
}

TEST(AlignmentWindow, RestPushesNothingOut) {
  AlignmentWindow window = make({});
  drive_on(window, 0, 100);
  // Ten minutes at a traffic light, with pose jitter of a centimetre.
  for (int i = 100; i < 6100; ++i) {
    window.add(pose((i + 1) * kTenth_ns, 99.0 + 0.01 * (i % 2)));
    window.add(fix((i + 1) * kTenth_ns));
  }
  EXPECT_TRUE(window.is_at_rest());
  EXPECT_EQ(window.path().size(), 100U);
  EXPECT_EQ(window.counts().fixes_at_rest, 5995) << "all but those of the first half second";
  window.add(pose(6101 * kTenth_ns, 100.0));
  EXPECT_FALSE(window.is_at_rest());
}

TEST(AlignmentWindow, APoseThatIsNotLaterBeginsAnotherWorld) {
  AlignmentWindow window = make({});
  drive_on(window, 0, 10);
  window.add(pose(3 * kTenth_ns, 0.0));
  EXPECT_EQ(window.path().size(), 1U);
  EXPECT_TRUE(window.fixes().empty());
  EXPECT_EQ(window.counts().restarts, 1);
}

TEST(AlignmentWindow, FixesComeInOrderAndAfterThePath) {
  AlignmentWindow window = make({});
  window.add(fix(1));
  EXPECT_TRUE(window.fixes().empty()) << "no pose yet";
  drive_on(window, 0, 10);
  window.add(fix(10 * kTenth_ns));
  window.add(fix(9 * kTenth_ns));
  EXPECT_EQ(window.fixes().size(), 10U);
  EXPECT_EQ(window.counts().fixes_out_of_order, 2);
}

TEST(AlignmentWindow, RefusesSettingsOutOfRange) {
  for (const AlignmentWindowConfig& config :
       {AlignmentWindowConfig{.max_path_m = 0.0}, AlignmentWindowConfig{.max_poses = 1},
        AlignmentWindowConfig{.max_fixes = 100'001}, AlignmentWindowConfig{.max_rest_s = std::nan("")}}) {
    EXPECT_FALSE(AlignmentWindow::create(config));
  }
}

// A path that drifts like odometry: the newest stretch agrees with its own fixes, within the sigmas.
TEST(AlignmentWindow, CovarianceOfTheNewestPlaceHoldsTheDriftOfThePath) {
  constexpr double kDrift = 0.01;
  constexpr int kTrials = 40;
  double normalised = 0.0;
  for (int trial = 0; trial < kTrials; ++trial) {
    std::mt19937 random(500U + static_cast<unsigned>(trial));
    std::normal_distribution<double> normal;
    const std::vector<PathPose> truth = test::drive(test::town());
    const test::Receiver receiver{.T_map_world = test::any_placement(random, 0.0), .noise_m = 0.3};
    const std::vector<Fix> fixes = test::receive(truth, receiver, random);
    const double length_m = test::town().length_m;
    std::vector<PathPose> odometry = truth;
    Eigen::Vector3d drift = Eigen::Vector3d::Zero();
    AlignmentWindow window = make({.max_path_m = 1000.0});
    for (std::size_t i = 0; i < odometry.size(); ++i) {
      odometry[i].T_world_cam.translation += drift;
      window.add(odometry[i]);
      if (i < fixes.size()) {
        window.add(fixes[i]);
      }
      const double step_m = length_m / static_cast<double>(odometry.size());
      drift += kDrift * length_m * std::sqrt(step_m / length_m) *
               Eigen::Vector3d(normal(random), normal(random), normal(random));
    }
    const AlignmentConfig config{.freedom = Freedom::kYaw, .max_time_offset_s = 0.0, .path_drift = kDrift};
    const Alignment alignment = align(window.path(), window.fixes(), config).value();
    ASSERT_EQ(alignment.verdict, Verdict::kAligned) << alignment.reason;
    const Eigen::Vector3d place = alignment.T_map_world * odometry.back().T_world_cam.translation;
    const Eigen::Vector3d error = place - receiver.T_map_world * truth.back().T_world_cam.translation;
    normalised += error.dot(live_covariance(alignment, place, kDrift, 0.0).inverse() * error) / 3.0 / kTrials;
  }
  RecordProperty("normalised", std::to_string(normalised));
  EXPECT_GT(normalised, 0.4);
  EXPECT_LT(normalised, 2.0);
}

}  // namespace
}  // namespace kinetrace::geo
