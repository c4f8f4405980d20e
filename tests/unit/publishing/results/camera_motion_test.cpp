#include "results/camera_motion.hpp"

#include <gtest/gtest.h>

#include "sample_results.hpp"

namespace kinetrace::publishing {
namespace {

using test::SampleResult;

PublishedFrame frame_at(std::int64_t frame) {
  PublishedFrame published;
  published.timestamp_ns = SampleResult::timestamp_ns(frame);
  published.camera.status = BodyStatus::kTracked;
  published.camera.T_world_cam = SampleResult::T_world_cam(frame);
  published.camera.covariance = 1e-4 * Matrix6d::Identity();
  return published;
}

TEST(CameraMotionMeter, SaysNothingAboutTheFirstFrame) {
  CameraMotionMeter meter;
  EXPECT_FALSE(meter.update(frame_at(0)).is_known);
}

TEST(CameraMotionMeter, MeasuresInTheCamerasOwnFrame) {
  CameraMotionMeter meter;
  static_cast<void>(meter.update(frame_at(50)));
  const CameraMotion motion = meter.update(frame_at(51));
  ASSERT_TRUE(motion.is_known);
  // The camera drives along the world's z while it looks to its right.
  const Eigen::Vector3d expected =
      SampleResult::T_world_cam(51).rotation.transpose() * Eigen::Vector3d(0.0, 0.0, SampleResult::kSpeed_mps);
  EXPECT_TRUE(motion.velocity_mps.isApprox(expected, 1e-9)) << motion.velocity_mps.transpose();
  EXPECT_TRUE(motion.angular_velocity_radps.isApprox(Eigen::Vector3d(0.0, SampleResult::kTurn_radps, 0.0), 1e-6));
  const double period_s = 1e-9 * SampleResult::kPeriod_ns;
  EXPECT_NEAR(motion.covariance(5, 5), 2e-4 / (period_s * period_s), 1e-9);
}

TEST(CameraMotionMeter, ForgetsAcrossAPauseOrALoss) {
  CameraMotionMeter meter;
  static_cast<void>(meter.update(frame_at(0)));
  EXPECT_TRUE(meter.update(frame_at(30)).is_known) << "a second is short enough";
  EXPECT_FALSE(meter.update(frame_at(61)).is_known);
  PublishedFrame lost = frame_at(62);
  lost.camera.status = BodyStatus::kPropagated;
  EXPECT_FALSE(meter.update(lost).is_known);
  EXPECT_FALSE(meter.update(frame_at(63)).is_known);
  EXPECT_TRUE(meter.update(frame_at(64)).is_known);
}

TEST(CameraMotionMeter, TimeThatStandsStillIsNoMotion) {
  CameraMotionMeter meter;
  static_cast<void>(meter.update(frame_at(3)));
  EXPECT_FALSE(meter.update(frame_at(3)).is_known);
}

}  // namespace
}  // namespace kinetrace::publishing
