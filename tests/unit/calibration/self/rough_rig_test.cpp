#include "rough_rig.hpp"

#include <random>

#include <gtest/gtest.h>

#include "synthetic_drive.hpp"

namespace kinetrace::self_calibration {
namespace {

/// Left-right pairs of the first frames, and a given number of wrong ones.
std::vector<PointPair> pairs_of(const RigModel& rig, std::size_t wrong) {
  std::vector<PointPair> pairs;
  for (const TrackWindow& window : test::synthetic_drive(rig, {.windows = 6, .noise_px = 0.3})) {
    for (const Track& track : window.tracks) {
      pairs.push_back({track.observations[0].raw_px, track.observations[1].raw_px});
    }
  }
  std::mt19937 random(3);
  std::uniform_real_distribution<double> x(0.0, 639.0);
  std::uniform_real_distribution<double> y(0.0, 479.0);
  for (std::size_t i = 0; i < wrong; ++i) {
    pairs.push_back({{x(random), y(random)}, {x(random), y(random)}});
  }
  return pairs;
}

TEST(RoughRig, FitsThePairsAmongWrongOnes) {
  const RigModel truth = test::distorted_rig();
  const std::vector<PointPair> right_pairs = pairs_of(truth, 0);
  const std::vector<PointPair> pairs = pairs_of(truth, right_pairs.size() / 4);
  const RoughRig rough = rough_rig(pairs, truth.size, truth.baseline_m, 512.0);
  EXPECT_LT(rough.rms_px, 1.5);
  EXPECT_GT(rough.inliers.size(), right_pairs.size() * 9 / 10);
  EXPECT_LT(rough.inliers.size(), right_pairs.size() * 11 / 10);
  EXPECT_NEAR(rough.rig.mount[kTurnZ], truth.mount[kTurnZ], 0.01);
}

TEST(RigModel, ProjectsAsItsCalibrationDoes) {
  const RigModel rig = test::distorted_rig();
  const hal::RigCalibration calibration = to_calibration(rig);
  const Eigen::Vector3d p_left(0.7, -0.4, 2.0);
  Eigen::Vector2d pixel;
  project(rig.lens[0].data(), rig.size, p_left.data(), pixel.data());
  EXPECT_LT((pixel - calibration.left.project(p_left)).norm(), 1e-9);
  EXPECT_NEAR(calibration.T_right_left.translation.norm(), rig.baseline_m, 1e-12);
  const RigModel back = to_model(calibration);
  for (std::size_t i = 0; i < kMountSize; ++i) {
    EXPECT_NEAR(back.mount[i], rig.mount[i], 1e-12);
  }
}

TEST(RigModel, UnprojectsAndTriangulatesWhatItProjects) {
  const RigModel rig = test::distorted_rig();
  const Eigen::Vector3d p_left(-1.3, 0.9, 3.0);
  const Eigen::Vector3d p_right = rig.T_right_left() * p_left;
  Eigen::Vector2d left_px;
  Eigen::Vector2d right_px;
  project(rig.lens[0].data(), rig.size, p_left.data(), left_px.data());
  project(rig.lens[1].data(), rig.size, p_right.data(), right_px.data());
  EXPECT_LT((unproject(rig.lens[0], rig.size, left_px) - p_left.hnormalized()).norm(), 1e-9);
  EXPECT_NEAR(inverse_depth(rig, left_px, right_px), 1.0 / 3.0, 1e-9);
}

}  // namespace
}  // namespace kinetrace::self_calibration
