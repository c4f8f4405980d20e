#include "kinetrace/evaluation/camera_metrics.hpp"

#include <numbers>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "kinetrace/evaluation/camera_rotation.hpp"

namespace kinetrace::evaluation {
namespace {

using ::testing::IsEmpty;

constexpr double kRadPerDeg = std::numbers::pi / 180.0;

/// A curved drive of one metre a frame, estimated without error.
std::vector<PosePair> perfect_drive(int frames) {
  std::vector<PosePair> pairs;
  Se3 pose;
  const Se3 step{so3_exp({0.001, 0.01, 0.002}), {0.0, 0.0, 1.0}};
  for (int i = 0; i < frames; ++i) {
    pairs.push_back({i, pose, pose});
    pose = pose * step;
  }
  return pairs;
}

TEST(CameraMetrics, AreZeroForTruthItself) {
  const CameraMetrics metrics = evaluate_camera(perfect_drive(60));
  EXPECT_EQ(metrics.frames, 60U);
  EXPECT_NEAR(metrics.path_m, 59.0, 1e-9);
  EXPECT_NEAR(metrics.ate_m.first.rmse().value(), 0.0, 1e-12);
  EXPECT_NEAR(metrics.ate_m.se3.rmse().value(), 0.0, 1e-9);
  EXPECT_NEAR(metrics.ate_m.sim3.rmse().value(), 0.0, 1e-9);
  EXPECT_NEAR(metrics.ate_m.scale.value(), 1.0, 1e-12);
  EXPECT_NEAR(metrics.rpe_translation_m.max().value(), 0.0, 1e-12);
  EXPECT_NEAR(metrics.rpe_rotation_deg.max().value(), 0.0, 1e-6);
  EXPECT_NEAR(metrics.t_rel_percent.value(), 0.0, 1e-12);
  EXPECT_NEAR(metrics.r_rel_deg_per_m.value(), 0.0, 1e-6);
}

TEST(CameraMetrics, DoNotDependOnWhereTheWorldsAre) {
  std::vector<PosePair> pairs = perfect_drive(60);
  const Se3 other_world{so3_exp({0.3, -2.0, 0.7}), {10.0, -20.0, 30.0}};
  for (PosePair& pair : pairs) {
    pair.T_world_cam = other_world * pair.T_world_cam;
  }
  const CameraMetrics metrics = evaluate_camera(pairs);
  EXPECT_NEAR(metrics.ate_m.first.max().value(), 0.0, 1e-9);
  EXPECT_NEAR(metrics.ate_m.se3.max().value(), 0.0, 1e-9);
  EXPECT_NEAR(metrics.t_rel_percent.value(), 0.0, 1e-9);
}

TEST(CameraMetrics, ShowAScaleErrorAsThatManyPercent) {
  std::vector<PosePair> pairs = perfect_drive(60);
  for (PosePair& pair : pairs) {
    pair.T_world_cam.translation *= 1.01;
  }
  const CameraMetrics metrics = evaluate_camera(pairs);
  // The chord of the curved path is a little shorter than the distance along it.
  EXPECT_NEAR(metrics.t_rel_percent.value(), 1.0, 0.01);
  EXPECT_NEAR(metrics.r_rel_deg_per_m.value(), 0.0, 1e-6);
  EXPECT_NEAR(metrics.rpe_translation_m.mean().value(), 0.01, 1e-9);
  EXPECT_NEAR(metrics.ate_m.scale.value(), 1.0 / 1.01, 1e-9);
  EXPECT_NEAR(metrics.ate_m.sim3.rmse().value(), 0.0, 1e-9);
  EXPECT_GT(metrics.ate_m.se3.rmse().value(), 0.01);
  EXPECT_GT(metrics.ate_m.first.rmse().value(), metrics.ate_m.se3.rmse().value());
}

TEST(CameraMetrics, ShowARotationErrorPerMetre) {
  std::vector<PosePair> pairs = perfect_drive(60);
  for (std::size_t i = 0; i < pairs.size(); ++i) {
    const double off_rad = 0.02 * kRadPerDeg * static_cast<double>(i);
    pairs[i].T_world_cam.rotation *= so3_exp({0.0, off_rad, 0.0});
  }
  const CameraMetrics metrics = evaluate_camera(pairs);
  EXPECT_NEAR(metrics.r_rel_deg_per_m.value(), 0.02, 2e-4);
  EXPECT_NEAR(metrics.rpe_rotation_deg.mean().value(), 0.02, 2e-4);
}

TEST(CameraMetrics, HaveKnownAbsoluteErrors) {
  std::vector<PosePair> pairs = perfect_drive(3);
  pairs[2].T_world_cam.translation += Eigen::Vector3d(0.0, 0.3, 0.0);
  const CameraMetrics metrics = evaluate_camera(pairs);
  EXPECT_NEAR(metrics.ate_m.first.max().value(), 0.3, 1e-12);
  EXPECT_NEAR(metrics.ate_m.first.mean().value(), 0.1, 1e-12);
  EXPECT_NEAR(metrics.ate_m.first.rmse().value(), 0.3 / std::sqrt(3.0), 1e-12);
}

TEST(CameraMetrics, UseShortLengthsUntilThePathHasTwoOfKittis) {
  const auto lengths = [](int frames) {
    std::vector<double> lengths_m;
    for (const SegmentErrors& segment : evaluate_camera(perfect_drive(frames)).segments) {
      lengths_m.push_back(segment.length_m);
    }
    return lengths_m;
  };
  EXPECT_THAT(lengths(25), ::testing::ElementsAre(5, 10, 20));
  EXPECT_THAT(lengths(200), ::testing::ElementsAre(5, 10, 20, 50, 100));
  EXPECT_THAT(lengths(202), ::testing::ElementsAre(100, 200));
}

TEST(CameraMetrics, CountASegmentForEachStart) {
  const CameraMetrics metrics = evaluate_camera(perfect_drive(7));  // 6 m and a bit for rounding.
  ASSERT_EQ(metrics.segments.size(), 1U);
  EXPECT_GE(metrics.segments[0].count, 1U);
  EXPECT_LE(metrics.segments[0].count, 2U);
}

TEST(CameraMetrics, HaveNoneOfWhatAShortPathCannotShow) {
  const CameraMetrics metrics = evaluate_camera(perfect_drive(3));
  EXPECT_FALSE(metrics.t_rel_percent);
  EXPECT_FALSE(metrics.r_rel_deg_per_m);
  EXPECT_THAT(metrics.segments, IsEmpty());
  EXPECT_TRUE(metrics.rpe_translation_m.mean());
}

TEST(CameraMetrics, HaveNoneOfNothing) {
  const CameraMetrics metrics = evaluate_camera({});
  EXPECT_EQ(metrics.frames, 0U);
  EXPECT_FALSE(metrics.ate_m.first.mean());
  EXPECT_FALSE(metrics.ate_m.se3.rmse());
  EXPECT_FALSE(metrics.rpe_translation_m.max());
}

TEST(CameraMetrics, HaveNoScaleWithoutMovement) {
  std::vector<PosePair> pairs = perfect_drive(5);
  for (PosePair& pair : pairs) {
    pair.T_world_cam_true.translation *= 0.01;
    pair.T_world_cam.translation *= 0.01;
  }
  const CameraMetrics metrics = evaluate_camera(pairs);
  EXPECT_FALSE(metrics.ate_m.scale);
  EXPECT_FALSE(metrics.ate_m.sim3.mean());
  EXPECT_NEAR(metrics.ate_m.se3.mean().value(), 0.0, 1e-12);
}

TEST(CameraMetrics, CompareOnlyConsecutiveFrames) {
  std::vector<PosePair> pairs = perfect_drive(10);
  pairs.erase(pairs.begin() + 4, pairs.begin() + 6);
  EXPECT_EQ(evaluate_camera(pairs).rpe_translation_m.count(), 6U);
}

TEST(CameraRotation, IsThatWhichWasPutIn) {
  std::vector<PosePair> pairs = perfect_drive(60);
  const Eigen::Matrix3d R_true = so3_exp({0.02, -0.01, 0.015});
  for (PosePair& pair : pairs) {
    pair.T_world_cam.rotation *= R_true.transpose();
  }
  EXPECT_NEAR(so3_log(camera_rotation(pairs) * R_true.transpose()).norm(), 0.0, 1e-9);
}

TEST(CameraRotation, IsIdentityWithoutMovementInTwoDirections) {
  std::vector<PosePair> straight;
  for (int i = 0; i < 30; ++i) {
    const Se3 pose{Eigen::Matrix3d::Identity(), {0.0, 0.0, static_cast<double>(i)}};
    straight.push_back({i, pose, pose});
  }
  EXPECT_TRUE(camera_rotation(straight).isIdentity());
  EXPECT_TRUE(camera_rotation(perfect_drive(5)).isIdentity());
}

}  // namespace
}  // namespace kinetrace::evaluation
