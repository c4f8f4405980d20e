// Stalls, losses and recoveries of a live camera, at exactly known times.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "live_camera_for_test.hpp"

namespace kinetrace::hal::test {
namespace {

using ::testing::HasSubstr;

TEST_F(LiveCamera, StallsThenIsLostAndNamesTheCamera) {
  begin();
  expect_frames(5);
  right_.mute = true;
  const std::int64_t muted_ns = machine_.now_ns();
  Result<StereoFrame> frame = camera_->next(kTimeout);
  EXPECT_EQ(frame.error().code, ErrorCode::kTimeout);
  EXPECT_EQ(camera_->state(), CameraState::kStreaming) << "100 ms are not yet a stall";
  while (machine_.now_ns() < muted_ns + 700 * kMs) {
    frame = camera_->next(kTimeout);
    EXPECT_EQ(frame.error().code, ErrorCode::kTimeout);
  }
  EXPECT_EQ(camera_->state(), CameraState::kStalled);
  EXPECT_THAT(frame.error().message, HasSubstr("right camera (fake at /dev/video2)"));
  EXPECT_EQ(camera_->counters().stalls, 1U);
  frame = frame_within(std::chrono::seconds(10));
  EXPECT_EQ(frame.error().code, ErrorCode::kDisconnected);
  EXPECT_THAT(frame.error().message, HasSubstr("right camera (fake at /dev/video2)"));
  EXPECT_EQ(camera_->state(), CameraState::kLost);
  EXPECT_LE(machine_.now_ns() - muted_ns, 2100 * kMs);
  EXPECT_EQ(camera_->counters().losses, 1U);
  EXPECT_EQ(left_.in_use + right_.in_use, 0);
}

TEST_F(LiveCamera, AStallThatEndsIsNoLoss) {
  begin();
  expect_frames(5);
  left_.mute = right_.mute = true;
  EXPECT_EQ(frame_within(std::chrono::milliseconds(900)).error().code, ErrorCode::kTimeout);
  EXPECT_EQ(camera_->state(), CameraState::kStalled);
  left_.mute = right_.mute = false;
  ASSERT_TRUE(frame_within(std::chrono::milliseconds(900)));
  EXPECT_EQ(camera_->state(), CameraState::kStreaming);
  expect_frames(5);
  EXPECT_EQ(camera_->counters().losses, 0U);
}

TEST_F(LiveCamera, UnreadableImagesAreNoData) {
  for (const bool is_flagged : {false, true}) {
    const auto spoil = [is_flagged](Shot& shot) {
      shot.damaged = is_flagged;
      shot.cut = !is_flagged;
    };
    begin();
    expect_frames(5);
    left_.script = spoil;
    expect_frames(1);  // Images in transit are still good.
    Result<StereoFrame> frame = frame_within(std::chrono::milliseconds(900));
    ASSERT_EQ(frame.error().code, ErrorCode::kTimeout);
    EXPECT_EQ(camera_->state(), CameraState::kStalled);
    EXPECT_THAT(frame.error().message, HasSubstr("images came damaged"));
    frame = frame_within(std::chrono::seconds(10));
    ASSERT_EQ(frame.error().code, ErrorCode::kDisconnected);
    EXPECT_THAT(frame.error().message, HasSubstr("images came damaged"));
    EXPECT_EQ(camera_->state(), CameraState::kLost);
    EXPECT_EQ(left_.in_use + right_.in_use, 0);
    left_.script = {};
  }
}

TEST_F(LiveCamera, OneDeviceIsNotReportedAsTwoThatDoNotFit) {
  begin_side_by_side();
  ASSERT_TRUE(camera_->next(kTimeout));
  left_.script = [stamp_ns = machine_.now_ns()](Shot& shot) { shot.stamp_ns = stamp_ns; };
  ASSERT_TRUE(camera_->next(kTimeout)) << "what was on its way is still good";
  ASSERT_TRUE(camera_->next(kTimeout)) << "the first of that stamp is new";
  const Result<StereoFrame> frame = frame_within(std::chrono::milliseconds(900));
  ASSERT_FALSE(frame);
  EXPECT_THAT(frame.error().message, HasSubstr("none is new"));
}

TEST_F(LiveCamera, ADeviceThatIsReadyForNothingIsNotAskedWithoutPause) {
  begin();
  expect_frames(5);
  left_.mute = left_.falsely_ready = true;
  // The machine's time advances only during a wait.
  EXPECT_EQ(camera_->next(kTimeout).error().code, ErrorCode::kTimeout);
  left_.mute = false;
  ASSERT_TRUE(frame_within(std::chrono::milliseconds(300)));
}

TEST_F(LiveCamera, DamagedImagesDoNotMakeACallLonger) {
  begin();
  expect_frames(5);
  // Each image takes longer than a period, so that there is always one more.
  constexpr std::int64_t kTaken_ns = 40 * kMs;
  left_.taking_ns = kTaken_ns;
  left_.script = [](Shot& shot) { shot.cut = true; };
  const std::int64_t begun_ns = machine_.now_ns();
  EXPECT_EQ(camera_->next(kTimeout).error().code, ErrorCode::kTimeout);
  const std::int64_t queued_ns = 2 * kTaken_ns * small_cameras().left.buffers;
  EXPECT_LE(machine_.now_ns() - begun_ns, std::chrono::nanoseconds(kTimeout).count() + queued_ns);
}

TEST_F(LiveCamera, AnExposureLongerThanTheStallTimeoutIsNoStall) {
  for (FakeSensor* sensor : {&left_, &right_}) {
    sensor->period_ns = 1000 * kMs;
    sensor->exposure_us = 900'000;
  }
  LiveCameraConfig config = small_cameras();
  config.left.rate_hz = config.right->rate_hz = 1.0;
  begin(config);
  for (int i = 0; i < 5; ++i) {
    ASSERT_TRUE(frame_within(std::chrono::milliseconds(1500)));
    EXPECT_EQ(camera_->counters().stalls, 0U);
  }
}

TEST_F(LiveCamera, ATriggeredCameraIsNeverLostForWantOfImages) {
  LiveCameraConfig config = small_cameras();
  config.left.trigger = config.right->trigger = TriggerMode::kExternal;
  begin(config);
  expect_frames(3);
  left_.mute = right_.mute = true;
  EXPECT_EQ(frame_within(std::chrono::seconds(60)).error().code, ErrorCode::kTimeout);
  EXPECT_EQ(camera_->state(), CameraState::kStalled);
}

TEST_F(LiveCamera, AnUnpluggedDeviceIsLostAtOnceAndComesBackUnderAnotherName) {
  begin();
  expect_frames(10);
  left_.plugged = false;
  const Result<StereoFrame> lost = camera_->next(kTimeout);
  ASSERT_FALSE(lost);
  EXPECT_EQ(lost.error().code, ErrorCode::kDisconnected);
  EXPECT_THAT(lost.error().message, HasSubstr("left camera"));
  EXPECT_EQ(camera_->state(), CameraState::kLost);

  // Attempts become rarer, so that a lost camera does not cost a core.
  machine_.attempts = 0;
  for (int i = 0; i < 1000; ++i) {
    EXPECT_EQ(camera_->recover().error().code, ErrorCode::kDisconnected);
    machine_.pass(10 * kMs);
  }
  EXPECT_GE(machine_.attempts, 5);
  EXPECT_LE(machine_.attempts, 10);

  left_.plugged = true;
  left_.path = "/dev/video7";
  Status recovered;
  for (int i = 0; i < 300; ++i) {
    recovered = camera_->recover();
    if (recovered) {
      break;
    }
    machine_.pass(10 * kMs);
  }
  ASSERT_TRUE(recovered) << recovered.error().message;
  EXPECT_EQ(camera_->state(), CameraState::kRecovering);
  EXPECT_EQ(camera_->info().name, "fake at /dev/video7 + fake at /dev/video2");
  const Result<StereoFrame> frame = camera_->next(kTimeout);
  ASSERT_TRUE(frame) << frame.error().message;
  EXPECT_EQ(camera_->state(), CameraState::kStreaming);
  EXPECT_GT(frame->frame_index, 10 + 10'000 / 33) << "the time without a camera is in the numbers";
  expect_frames(10);
  EXPECT_EQ(camera_->counters().recoveries, 1U);
}

TEST_F(LiveCamera, ADeviceNamedByItsSerialNumberIsFoundInAnotherSocket) {
  left_.serial = "SN1";
  LiveCameraConfig config = small_cameras();
  config.left.device = "SN1";
  begin(config);
  expect_frames(3);
  lose(left_);
  left_.plugged = true;
  left_.path = "/dev/video7";
  left_.stable_id = "usb-9";
  machine_.pass(200 * kMs);
  const Status recovered = camera_->recover();
  ASSERT_TRUE(recovered) << recovered.error().message;
  expect_frames(3);
}

TEST_F(LiveCamera, AnotherDeviceInItsPlaceIsNotTaken) {
  left_.serial = "SN1";
  begin();
  expect_frames(3);
  lose(left_);
  left_.plugged = true;
  left_.serial = "SN2";
  machine_.pass(200 * kMs);
  const Status other = camera_->recover();
  ASSERT_FALSE(other);
  EXPECT_EQ(other.error().code, ErrorCode::kDisconnected);
  EXPECT_THAT(other.error().message, HasSubstr("another device"));
  left_.serial = "SN1";
  machine_.pass(500 * kMs);
  EXPECT_TRUE(camera_->recover());
}

TEST_F(LiveCamera, WhereOnlyThePathIsKnownTheNameMustBeAsBefore) {
  left_.stable_id = left_.path;
  begin();
  lose(left_);
  left_.path = left_.stable_id = "/dev/video9";
  machine_.add({.path = "/dev/video8", .stable_id = "/dev/video0"});
  machine_.pass(200 * kMs);
  EXPECT_THAT(camera_->recover().error().message, HasSubstr("another device"));
}

TEST_F(LiveCamera, AStreamErrorIsMendedByStartingAgain) {
  begin();
  expect_frames(5);
  left_.stream_broken = true;
  expect_frames(20);
  EXPECT_EQ(left_.started, 2);
  EXPECT_EQ(camera_->counters().losses, 0U);
  EXPECT_LE(left_.in_use, 3);
  EXPECT_EQ(camera_->counters().stream_restarts, 1U);
}

TEST_F(LiveCamera, AStreamErrorThatKeepsComingBackIsALoss) {
  begin();
  expect_frames(5);
  left_.stream_broken = left_.never_mends = true;
  const Result<StereoFrame> lost = camera_->next(kTimeout);
  ASSERT_FALSE(lost);
  EXPECT_EQ(lost.error().code, ErrorCode::kDisconnected);
  EXPECT_THAT(lost.error().message, HasSubstr("stream error"));
  left_.never_mends = false;
  machine_.pass(200 * kMs);
  ASSERT_TRUE(camera_->recover());
  left_.stream_broken = true;
  expect_frames(3);
  EXPECT_EQ(camera_->counters().losses, 1U) << "after a recovery an error is the first one again";
}

TEST_F(LiveCamera, RefusesIllegalCallsWhileLostAndWhileRecovering) {
  begin();
  expect_frames(1);
  lose(left_);
  for (const Status& refused : {camera_->open(), camera_->start(), camera_->stop()}) {
    EXPECT_EQ(refused.error().code, ErrorCode::kIllegalState);
  }
  EXPECT_EQ(camera_->next(kTimeout).error().code, ErrorCode::kIllegalState);
  EXPECT_EQ(camera_->state(), CameraState::kLost);
  left_.plugged = true;
  machine_.pass(200 * kMs);
  ASSERT_TRUE(camera_->recover());
  for (const Status& refused : {camera_->open(), camera_->start(), camera_->recover()}) {
    EXPECT_EQ(refused.error().code, ErrorCode::kIllegalState);
  }
  EXPECT_EQ(camera_->state(), CameraState::kRecovering);
  left_.mute = true;
  EXPECT_EQ(camera_->next(kTimeout).error().code, ErrorCode::kTimeout);
  EXPECT_EQ(camera_->state(), CameraState::kRecovering);
  EXPECT_EQ(frame_within(std::chrono::seconds(5)).error().code, ErrorCode::kDisconnected);
  EXPECT_EQ(camera_->state(), CameraState::kLost);
}

}  // namespace
}  // namespace kinetrace::hal::test
