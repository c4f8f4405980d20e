// Frame times: middle of the exposure, correct under any behaviour of clocks and schedulers.
#include <gtest/gtest.h>

#include "live_camera_for_test.hpp"

namespace kinetrace::hal::test {
namespace {

TEST_F(LiveCamera, TakesTheMiddleOfTheExposure) {
  for (FakeSensor* sensor : {&left_, &right_}) {
    sensor->exposure_us = 10'000;
    sensor->phase_ns = machine_.now_ns() + 7 * kMs;
  }
  begin();
  const std::int64_t end_ns = left_.phase_ns;
  EXPECT_EQ(camera_->next(kTimeout).value().timestamp_ns, end_ns - 5 * kMs);
  camera_->close();
  for (FakeSensor* sensor : {&left_, &right_}) {
    sensor->timestamp_kind = TimestampKind::kStartOfExposure;
    sensor->phase_ns = machine_.now_ns() + 7 * kMs;
  }
  ASSERT_TRUE(camera_->open() && camera_->start());
  EXPECT_EQ(camera_->next(kTimeout).value().timestamp_ns, left_.phase_ns + 5 * kMs);
}

TEST_F(LiveCamera, TakesTheMiddleOfAnExposureThatEachImageTells) {
  left_.given_exposure_ns = right_.given_exposure_ns = 10 * kMs;
  left_.phase_ns = right_.phase_ns = machine_.now_ns() + 7 * kMs;
  begin();
  EXPECT_EQ(camera_->next(kTimeout).value().timestamp_ns, left_.phase_ns - 5 * kMs);
  // An impossible value is rejected: no exposure is longer than a period.
  left_.given_exposure_ns = right_.given_exposure_ns = 900 * kMs;
  camera_->close();
  ASSERT_TRUE(camera_->open() && camera_->start());
  const StereoFrame frame = camera_->next(kTimeout).value();
  EXPECT_LE(machine_.now_ns() - frame.timestamp_ns, left_.period_ns);
}

// Images that waited in the driver are older than their arrival; later images are not.
TEST_F(LiveCamera, TimesAreRightAfterAHoldUpHoweverLong) {
  for (const std::int64_t held_up_ms : {300, 1000, 1500, 5'000, 60'000}) {
    for (const bool counts : {true, false}) {
      left_.sequence_counts_losses = right_.sequence_counts_losses = counts;
      begin();
      expect_frames(5);
      machine_.pass(held_up_ms * kMs);
      for (int i = 0; i < 20; ++i) {
        const Result<StereoFrame> frame = camera_->next(kTimeout);
        ASSERT_TRUE(frame) << frame.error().message;
        const std::int64_t shot = (frame->timestamp_ns - left_.phase_ns) / left_.period_ns;
        EXPECT_EQ(frame->timestamp_ns, left_.phase_ns + shot * left_.period_ns) << held_up_ms << " ms, frame " << i;
        EXPECT_EQ(frame->left.at(0, 0), shot % 256) << held_up_ms << " ms, frame " << i;
      }
      EXPECT_EQ(camera_->counters().clock_jumps, 0U) << held_up_ms << " ms";
      camera_->close();
    }
  }
}

TEST_F(LiveCamera, AClockThatJumpsAfterAHoldUpIsStillMended) {
  begin();
  expect_frames(5);
  machine_.pass(5'000 * kMs);
  expect_frames(5);
  const std::int64_t before_ns = camera_->next(kTimeout).value().timestamp_ns;
  left_.script = right_.script = [](Shot& shot) { shot.stamp_ns += 3'600'000 * kMs; };
  expect_frames(1);  // On its way.
  const StereoFrame after = camera_->next(kTimeout).value();
  EXPECT_NEAR(static_cast<double>(after.timestamp_ns - before_ns), static_cast<double>(2 * left_.period_ns), kMs);
  EXPECT_EQ(camera_->counters().clock_jumps, 2U) << "one in each camera";
}

TEST_F(LiveCamera, DtAcrossALossIsTheTimeThatPassed) {
  begin();
  expect_frames(9);
  const StereoFrame before = camera_->next(kTimeout).value();
  const std::int64_t before_ns = before.timestamp_ns;
  lose(right_);
  machine_.pass(5000 * kMs);
  right_.plugged = true;
  ASSERT_TRUE(camera_->recover());
  const std::int64_t expected_ns = ((machine_.now_ns() - left_.phase_ns) / left_.period_ns + 1) * left_.period_ns;
  const StereoFrame after = camera_->next(kTimeout).value();
  EXPECT_EQ(after.timestamp_ns - left_.phase_ns, expected_ns);
  EXPECT_EQ((after.timestamp_ns - before_ns) / left_.period_ns, after.frame_index - before.frame_index);
  EXPECT_EQ(camera_->counters().clock_jumps, 0U);
}

TEST_F(LiveCamera, ADeviceClockThatJumpsDoesNotReachTheFrames) {
  left_.script = [](Shot& shot) { shot.stamp_ns += shot.number >= 10 && shot.number < 30 ? 3'600'000 * kMs : 0; };
  right_.script = [](Shot& shot) { shot.stamp_ns -= shot.number >= 20 ? 50'000 * kMs : 0; };
  begin();
  std::int64_t previous_ns = 0;
  std::int64_t previous_shot = -1;
  for (int i = 0; i < 60; ++i) {
    const Result<StereoFrame> frame = camera_->next(kTimeout);
    ASSERT_TRUE(frame) << frame.error().message;
    EXPECT_EQ(frame->left.at(0, 0), frame->right.at(0, 0)) << i;
    if (i > 0) {
      const std::int64_t steps = frame->left.at(0, 0) - previous_shot;
      EXPECT_NEAR(static_cast<double>(frame->timestamp_ns - previous_ns), static_cast<double>(steps * left_.period_ns),
                  static_cast<double>(kMs));
    }
    previous_ns = frame->timestamp_ns;
    previous_shot = frame->left.at(0, 0);
  }
  EXPECT_EQ(camera_->counters().clock_jumps, 3U);
}

TEST_F(LiveCamera, AClockThatStepsBackALittleCostsNoFrames) {
  for (FakeSensor* sensor : {&left_, &right_}) {
    sensor->script = [](Shot& shot) { shot.stamp_ns -= shot.number >= 10 ? 500 * kMs : 0; };
  }
  begin();
  std::int64_t previous_ns = 0;
  for (int i = 0; i < 30; ++i) {
    const Result<StereoFrame> frame = camera_->next(kTimeout);
    ASSERT_TRUE(frame) << frame.error().message;
    if (i > 0) {
      EXPECT_NEAR(static_cast<double>(frame->timestamp_ns - previous_ns), static_cast<double>(left_.period_ns), kMs);
    }
    previous_ns = frame->timestamp_ns;
  }
  EXPECT_EQ(camera_->counters().clock_jumps, 2U) << "one in each camera";
  EXPECT_EQ(camera_->counters().skipped_repeated, 0U);
}

}  // namespace
}  // namespace kinetrace::hal::test
