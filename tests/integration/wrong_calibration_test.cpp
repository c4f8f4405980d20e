// Rendered drives whose right camera is not mounted as calibrated.
#include <cmath>
#include <string>

#include <gtest/gtest.h>

#include "simulated_sequence.hpp"
#include "temp_folder.hpp"

namespace kinetrace::test {
namespace {

using rig::RefineMode;

constexpr int kWidth_px = 620;
constexpr int kFrames = 36;
constexpr double kDegree_rad = M_PI / 180.0;

class Drive {
 public:
  explicit Drive(const simulator::RigErrors& errors)
      : sequence_(folder_.path() / "street", "street", kFrames, kWidth_px, errors) {}

  [[nodiscard]] Followed follow(RefineMode mode) const {
    pipeline::PipelineConfig config = sequence_.masked();
    config.calibration.mode = mode;
    return sequence_.follow(config);
  }

 private:
  TempFolder folder_;
  SimulatedSequence sequence_;
};

/// Length of the camera's path from a frame on, relative to the true one.
double scale_from(const Followed& followed, std::size_t first) {
  double length_m = 0.0;
  double true_length_m = 0.0;
  for (std::size_t i = first + 1; i < followed.finalised.size(); ++i) {
    const FollowedFrame& before = followed.finalised[i - 1];
    const FollowedFrame& now = followed.finalised[i];
    length_m += (now.camera.T_world_cam.translation - before.camera.T_world_cam.translation).norm();
    true_length_m += (now.T_world_cam_true.translation - before.T_world_cam_true.translation).norm();
  }
  return length_m / true_length_m;
}

TEST(WrongCalibration, ATurnedRightCameraIsFoundAndCorrected) {
  const Drive drive({.turn_rad = kDegree_rad * Eigen::Vector3d(0.2, -0.25, 0.15)});
  const Followed corrected = drive.follow(RefineMode::kOn);
  EXPECT_EQ(corrected.rig.verdict, RigVerdict::kCorrected);
  EXPECT_NEAR(corrected.rig.correction.turn_rad.x() / kDegree_rad, 0.2, 0.01);
  EXPECT_NEAR(corrected.rig.correction.disparity_error_rad() / kDegree_rad, -0.25, 0.01);
  EXPECT_NEAR(corrected.rig.correction.turn_rad.z() / kDegree_rad, 0.15, 0.01);
  constexpr std::size_t kFirst = 12;
  EXPECT_NEAR(scale_from(corrected, kFirst), 1.0, 0.006);
  EXPECT_GT(std::abs(scale_from(drive.follow(RefineMode::kOff), kFirst) - 1.0), 0.05);
}

// In pictures of half the size, half of the features have no match.
TEST(WrongCalibration, OffInAllAnglesARigIsCorrected) {
  const Drive drive({.turn_rad = kDegree_rad * Eigen::Vector3d(0.35, -0.2, 0.3),
                     .baseline_rad = kDegree_rad * Eigen::Vector2d(-0.3, 0.4)});
  const Followed corrected = drive.follow(RefineMode::kOn);
  EXPECT_EQ(corrected.rig.verdict, RigVerdict::kCorrected);
  EXPECT_NEAR(corrected.rig.correction.turn_rad.x() / kDegree_rad, 0.35, 0.02);
  EXPECT_NEAR(corrected.rig.correction.disparity_error_rad() / kDegree_rad, -0.2, 0.02);
  constexpr std::size_t kFirst = 20;
  EXPECT_NEAR(scale_from(corrected, kFirst), 1.0, 0.01);
}

TEST(WrongCalibration, CheckingTellsItAndChangesNothing) {
  const Drive drive({.turn_rad = kDegree_rad * Eigen::Vector3d(0.0, 0.1, 0.0)});
  const Followed checked = drive.follow(RefineMode::kCheck);
  EXPECT_EQ(checked.rig.verdict, RigVerdict::kOff);
  EXPECT_NEAR(checked.rig.correction.disparity_error_rad() / kDegree_rad, 0.1, 0.01);
  const Followed off = drive.follow(RefineMode::kOff);
  for (std::size_t i = 0; i < off.finalised.size(); ++i) {
    ASSERT_EQ(checked.finalised[i].camera.T_world_cam.translation, off.finalised[i].camera.T_world_cam.translation);
  }
}

TEST(WrongCalibration, WithATrueOneResultsAreThoseWithoutRefinementBitForBit) {
  const Drive drive({});
  const Followed on = drive.follow(RefineMode::kOn);
  const Followed off = drive.follow(RefineMode::kOff);
  EXPECT_EQ(on.rig.verdict, RigVerdict::kHolds);
  EXPECT_EQ(off.rig.windows, 0U);
  ASSERT_EQ(on.finalised.size(), off.finalised.size());
  for (std::size_t i = 0; i < on.finalised.size(); ++i) {
    ASSERT_EQ(on.finalised[i].camera.T_world_cam.translation, off.finalised[i].camera.T_world_cam.translation);
    ASSERT_EQ(on.finalised[i].objects.size(), off.finalised[i].objects.size());
  }
}

}  // namespace
}  // namespace kinetrace::test
