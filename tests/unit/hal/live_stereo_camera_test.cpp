// Two scripted devices in, pairs out; everything that goes wrong with cameras, at exactly known times.
#include "kinetrace/hal/live_stereo_camera.hpp"

#include <random>
#include <set>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "fake_capture.hpp"

namespace kinetrace::hal::test {
namespace {

using ::testing::HasSubstr;

constexpr std::chrono::milliseconds kTimeout{100};

LiveCameraConfig two_eyes() {
  LiveCameraConfig config;
  config.left.device = "/dev/video0";
  config.left.width_px = 48;
  config.left.height_px = 32;
  config.left.rate_hz = 1e9 / static_cast<double>(33 * kMs);
  config.right = config.left;
  config.right->device = "/dev/video2";
  return config;
}

class LiveCamera : public ::testing::Test {
 protected:
  void make(const LiveCameraConfig& config = two_eyes()) {
    arena_.emplace(LiveStereoCamera::required_bytes(config) + Arena::kAlignment);
    camera_.emplace(LiveStereoCamera::create(config, *arena_, machine_).value());
  }
  void begin(const LiveCameraConfig& config = two_eyes()) {
    make(config);
    ASSERT_TRUE(camera_->open() && camera_->start());
  }
  /// Calls next() until it gives a frame or has been silent for `patience`.
  Result<StereoFrame> frame_within(std::chrono::milliseconds patience) {
    const std::int64_t until_ns = machine_.now_ns() + std::chrono::nanoseconds(patience).count();
    for (;;) {
      Result<StereoFrame> frame = camera_->next(kTimeout);
      if (frame || frame.error().code != ErrorCode::kTimeout || machine_.now_ns() >= until_ns) {
        return frame;
      }
    }
  }
  void expect_frames(int count) {
    for (int i = 0; i < count; ++i) {
      const Result<StereoFrame> frame = camera_->next(kTimeout);
      ASSERT_TRUE(frame) << i << ": " << frame.error().message;
      EXPECT_EQ(frame->left.at(0, 0), frame->right.at(0, 0)) << "shots of different times";
    }
  }

  FakeMachine machine_;
  FakeSensor& left_ = machine_.add({.path = "/dev/video0", .stable_id = "usb-1"});
  FakeSensor& right_ = machine_.add({.path = "/dev/video2", .stable_id = "usb-2"});
  std::optional<Arena> arena_;
  std::optional<LiveStereoCamera> camera_;
};

TEST_F(LiveCamera, PairsShotsOfTheSameTimeInOrderWithoutGaps) {
  begin();
  std::int64_t previous_ns = 0;
  for (int i = 0; i < 50; ++i) {
    const Result<StereoFrame> frame = camera_->next(kTimeout);
    ASSERT_TRUE(frame) << frame.error().message;
    EXPECT_EQ(frame->left.at(3, 3), frame->right.at(3, 3));
    EXPECT_EQ(frame->frame_index, i);
    if (i > 0) {
      EXPECT_EQ(frame->timestamp_ns - previous_ns, left_.period_ns);
    }
    previous_ns = frame->timestamp_ns;
  }
  EXPECT_EQ(camera_->counters().frames_delivered, 50U);
  EXPECT_EQ(camera_->counters().skipped_missing_side, 0U);
  EXPECT_EQ(camera_->counters().gaps, 0U);
}

TEST_F(LiveCamera, ViewsTheDevicesBuffersInPlaceAndGivesThemBack) {
  begin();
  const Result<StereoFrame> frame = camera_->next(kTimeout);
  ASSERT_TRUE(frame);
  EXPECT_EQ(frame->left.stride, 48 + 16) << "a copy would have another stride";
  EXPECT_EQ(left_.in_use, 1);
  expect_frames(100);
  EXPECT_LE(left_.most_in_use, 3);
  EXPECT_LE(right_.most_in_use, 3);
  ASSERT_TRUE(camera_->stop());
  EXPECT_EQ(left_.in_use, 0);
  EXPECT_EQ(right_.in_use, 0);
}

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
  left_.told_exposure_ns = right_.told_exposure_ns = 10 * kMs;
  left_.phase_ns = right_.phase_ns = machine_.now_ns() + 7 * kMs;
  begin();
  EXPECT_EQ(camera_->next(kTimeout).value().timestamp_ns, left_.phase_ns - 5 * kMs);
  // What cannot be true is not believed: no exposure is longer than a period.
  left_.told_exposure_ns = right_.told_exposure_ns = 900 * kMs;
  camera_->close();
  ASSERT_TRUE(camera_->open() && camera_->start());
  const StereoFrame frame = camera_->next(kTimeout).value();
  EXPECT_LE(machine_.now_ns() - frame.timestamp_ns, left_.period_ns);
}

TEST_F(LiveCamera, GivesTheNewestPairToWhoeverIsSlow) {
  begin();
  ASSERT_TRUE(camera_->next(kTimeout));
  machine_.pass(3 * left_.period_ns);
  const Result<StereoFrame> frame = camera_->next(kTimeout);
  ASSERT_TRUE(frame);
  EXPECT_EQ(frame->frame_index, 3);
  EXPECT_EQ(camera_->counters().skipped_outdated, 2U);
  EXPECT_EQ(frame->left.at(0, 0), frame->right.at(0, 0));
}

TEST_F(LiveCamera, SplitsASideBySideImageWithoutACopy) {
  left_.side_by_side = true;
  LiveCameraConfig config = two_eyes();
  config.right.reset();
  begin(config);
  EXPECT_EQ(camera_->info().width_px, 24);
  const Result<StereoFrame> frame = camera_->next(kTimeout);
  ASSERT_TRUE(frame) << frame.error().message;
  EXPECT_EQ(frame->left.width, 24);
  EXPECT_EQ(frame->right.width, 24);
  EXPECT_EQ(frame->right.data, frame->left.data + 24);
  EXPECT_EQ(frame->right.at(23, 31), static_cast<std::uint8_t>(frame->left.at(23, 31) + 100));
}

TEST_F(LiveCamera, CountsLostAndDamagedImagesAndDropsTheirPartners) {
  left_.script = [](Shot& shot) { shot.lost = shot.number == 5; };
  right_.script = [](Shot& shot) { shot.damaged = shot.number == 8; };
  begin();
  std::int64_t last_index = -1;
  for (int i = 0; i < 20; ++i) {
    const Result<StereoFrame> frame = camera_->next(kTimeout);
    ASSERT_TRUE(frame);
    EXPECT_EQ(frame->left.at(0, 0), frame->right.at(0, 0));
    last_index = frame->frame_index;
  }
  EXPECT_EQ(last_index, 21) << "two frames are missing, and the numbers say so";
  EXPECT_EQ(camera_->counters().gaps, 0U) << "of each, an image of one eye came";
  EXPECT_EQ(camera_->counters().skipped_unreadable, 1U);
  EXPECT_EQ(camera_->counters().skipped_missing_side, 2U);
}

TEST_F(LiveCamera, FramesThatBothEyesLostAreGapsWhetherOrNotTheDriverCounts) {
  for (const bool counts : {true, false}) {
    for (FakeSensor* sensor : {&left_, &right_}) {
      sensor->sequence_counts_losses = counts;
      sensor->script = [](Shot& shot) { shot.lost = shot.number % 10 == 4 || shot.number % 10 == 5; };
    }
    begin();
    std::int64_t last_index = -1;
    for (int i = 0; i < 40; ++i) {
      const Result<StereoFrame> frame = camera_->next(kTimeout);
      ASSERT_TRUE(frame);
      last_index = frame->frame_index;
    }
    const CameraCounters& counters = camera_->counters();
    EXPECT_GE(counters.gaps, 8U);
    EXPECT_EQ(counters.frames_delivered + counters.gaps, static_cast<std::uint64_t>(last_index + 1));
    EXPECT_EQ(counters.skipped_missing_side, 0U);
  }
}

TEST_F(LiveCamera, EveryFrameNumberIsAccountedForOnce) {
  for (const bool counts : {true, false}) {
    std::mt19937 random(5);
    std::bernoulli_distribution loses(0.2);
    for (FakeSensor* sensor : {&left_, &right_}) {
      sensor->sequence_counts_losses = counts;
      sensor->script = [&](Shot& shot) { shot.lost = loses(random); };
    }
    begin();
    std::int64_t first_index = -1;
    std::int64_t last_index = -1;
    for (int i = 0; i < 300; ++i) {
      const Result<StereoFrame> frame = frame_within(std::chrono::seconds(1));
      ASSERT_TRUE(frame) << frame.error().message;
      EXPECT_EQ(frame->left.at(0, 0), frame->right.at(0, 0));
      first_index = i == 0 ? frame->frame_index : first_index;
      last_index = frame->frame_index;
      if (i == 0) {
        // What was lost before the first pair is nobody's.
        first_index -= static_cast<std::int64_t>(camera_->counters().skipped_missing_side);
      }
      machine_.pass(i % 3 == 0 ? 80 * kMs : 0);
    }
    const CameraCounters& counters = camera_->counters();
    EXPECT_GT(counters.gaps, 10U);
    EXPECT_GT(counters.skipped_missing_side, 50U);
    EXPECT_GT(counters.skipped_outdated, 20U);
    const std::uint64_t accounted =
        counters.frames_delivered + counters.gaps + counters.skipped_missing_side + counters.skipped_outdated;
    EXPECT_EQ(accounted, static_cast<std::uint64_t>(last_index - first_index + 1)) << "counts: " << counts;
    left_.script = right_.script = {};
    camera_->close();
  }
}

TEST_F(LiveCamera, WhatTheDriverLostWhileWeWereHeldUpIsAGap) {
  begin();
  expect_frames(5);
  machine_.pass(1000 * kMs);
  const Result<StereoFrame> stale = camera_->next(kTimeout);
  ASSERT_TRUE(stale);
  const Result<StereoFrame> fresh = camera_->next(kTimeout);
  ASSERT_TRUE(fresh);
  const CameraCounters& counters = camera_->counters();
  EXPECT_GE(counters.gaps, 20U);
  EXPECT_EQ(counters.frames_delivered + counters.gaps + counters.skipped_outdated,
            static_cast<std::uint64_t>(fresh->frame_index + 1));
}

// Images that waited in the driver meanwhile are older than their arrival says; so are none of those that follow.
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
  EXPECT_EQ(camera_->counters().clock_jumps, 2U) << "one in each eye";
}

TEST_F(LiveCamera, SkipsACutImage) {
  left_.script = [](Shot& shot) { shot.cut = shot.number == 2; };
  begin();
  expect_frames(6);
  EXPECT_EQ(camera_->counters().skipped_unreadable, 1U);
  EXPECT_EQ(left_.in_use, 1);
}

TEST_F(LiveCamera, NeverGivesAStaleImageAgain) {
  // The driver hands out shot 4 once more in place of shots 5 and 6.
  for (FakeSensor* sensor : {&left_, &right_}) {
    sensor->sequence_counts_losses = false;
    sensor->script = [sensor](Shot& shot) {
      if (shot.number == 5 || shot.number == 6) {
        shot.stamp_ns = sensor->phase_ns + 4 * sensor->period_ns;
      }
    };
  }
  begin();
  std::set<std::int64_t> times;
  for (int i = 0; i < 12; ++i) {
    const Result<StereoFrame> frame = camera_->next(kTimeout);
    ASSERT_TRUE(frame);
    EXPECT_TRUE(times.insert(frame->timestamp_ns).second);
    EXPECT_TRUE(frame->left.at(0, 0) != 5 && frame->left.at(0, 0) != 6);
  }
  EXPECT_EQ(camera_->counters().skipped_repeated, 4U);
}

TEST_F(LiveCamera, FallsSilentThenIsLostAndNamesTheEye) {
  begin();
  expect_frames(5);
  right_.mute = true;
  const std::int64_t silent_since_ns = machine_.now_ns();
  Result<StereoFrame> frame = camera_->next(kTimeout);
  EXPECT_EQ(frame.error().code, ErrorCode::kTimeout);
  EXPECT_EQ(camera_->state(), CameraState::kStreaming) << "100 ms are not yet silence";
  while (machine_.now_ns() < silent_since_ns + 700 * kMs) {
    frame = camera_->next(kTimeout);
    EXPECT_EQ(frame.error().code, ErrorCode::kTimeout);
  }
  EXPECT_EQ(camera_->state(), CameraState::kStalled);
  EXPECT_THAT(frame.error().message, HasSubstr("right eye (fake at /dev/video2)"));
  EXPECT_EQ(camera_->counters().stalls, 1U);
  frame = frame_within(std::chrono::seconds(10));
  EXPECT_EQ(frame.error().code, ErrorCode::kDisconnected);
  EXPECT_THAT(frame.error().message, HasSubstr("right eye (fake at /dev/video2)"));
  EXPECT_EQ(camera_->state(), CameraState::kLost);
  EXPECT_LE(machine_.now_ns() - silent_since_ns, 2100 * kMs);
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

TEST_F(LiveCamera, ImagesThatCannotBeReadAreSilence) {
  for (const bool is_flagged : {false, true}) {
    const auto spoil = [is_flagged](Shot& shot) {
      shot.damaged = is_flagged;
      shot.cut = !is_flagged;
    };
    begin();
    expect_frames(5);
    left_.script = spoil;
    expect_frames(1);  // What was on its way is still good.
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

TEST_F(LiveCamera, OneDeviceIsNotToldThatItsEyesDoNotFit) {
  left_.side_by_side = true;
  LiveCameraConfig config = two_eyes();
  config.right.reset();
  begin(config);
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
  // The machine's time goes on only while somebody waits.
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
  const std::int64_t queued_ns = 2 * two_eyes().left.buffers * kTaken_ns;
  EXPECT_LE(machine_.now_ns() - begun_ns, std::chrono::nanoseconds(kTimeout).count() + queued_ns);
}

TEST_F(LiveCamera, BearsAnExposureLongerThanTheStallTime) {
  for (FakeSensor* sensor : {&left_, &right_}) {
    sensor->period_ns = 1000 * kMs;
    sensor->exposure_us = 900'000;
  }
  LiveCameraConfig config = two_eyes();
  config.left.rate_hz = config.right->rate_hz = 1.0;
  begin(config);
  for (int i = 0; i < 5; ++i) {
    ASSERT_TRUE(frame_within(std::chrono::milliseconds(1500)));
    EXPECT_EQ(camera_->counters().stalls, 0U);
  }
}

TEST_F(LiveCamera, ATriggeredCameraMayBeSilentForEver) {
  LiveCameraConfig config = two_eyes();
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
  EXPECT_THAT(lost.error().message, HasSubstr("left eye"));
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
  LiveCameraConfig config = two_eyes();
  config.left.device = "SN1";
  begin(config);
  expect_frames(3);
  left_.plugged = false;
  EXPECT_FALSE(camera_->next(kTimeout));
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
  left_.plugged = false;
  EXPECT_FALSE(camera_->next(kTimeout));
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
  left_.plugged = false;
  EXPECT_FALSE(camera_->next(kTimeout));
  left_.path = left_.stable_id = "/dev/video9";
  machine_.add({.path = "/dev/video8", .stable_id = "/dev/video0"});
  machine_.pass(200 * kMs);
  EXPECT_THAT(camera_->recover().error().message, HasSubstr("another device"));
}

TEST_F(LiveCamera, ARateThatNobodyToldIsMeasuredAndMustBeTheOneAskedFor) {
  for (FakeSensor* sensor : {&left_, &right_}) {
    sensor->tells_rate = false;
    sensor->script = [](Shot& shot) { shot.lost = shot.number % 5 == 0; };
  }
  begin();
  expect_frames(100);
  camera_->close();
  right_.period_ns = 66 * kMs;
  ASSERT_TRUE(camera_->open() && camera_->start());
  const Result<StereoFrame> frame = [&] {
    Result<StereoFrame> next = camera_->next(kTimeout);
    for (int i = 0; i < 100 && (next || next.error().code == ErrorCode::kTimeout); ++i) {
      next = camera_->next(kTimeout);
    }
    return next;
  }();
  ASSERT_FALSE(frame);
  EXPECT_THAT(frame.error().message, HasSubstr("right eye"));
  EXPECT_THAT(frame.error().message, HasSubstr("asked for 30.303 Hz, the device delivers 15.1515 Hz"));
}

TEST_F(LiveCamera, DtAcrossALossIsTheTimeThatPassed) {
  begin();
  expect_frames(9);
  const StereoFrame before = camera_->next(kTimeout).value();
  const std::int64_t before_ns = before.timestamp_ns;
  right_.plugged = false;
  EXPECT_EQ(camera_->next(kTimeout).error().code, ErrorCode::kDisconnected);
  machine_.pass(5000 * kMs);
  right_.plugged = true;
  ASSERT_TRUE(camera_->recover());
  const std::int64_t expected_ns = ((machine_.now_ns() - left_.phase_ns) / left_.period_ns + 1) * left_.period_ns;
  const StereoFrame after = camera_->next(kTimeout).value();
  EXPECT_EQ(after.timestamp_ns - left_.phase_ns, expected_ns);
  EXPECT_EQ((after.timestamp_ns - before_ns) / left_.period_ns, after.frame_index - before.frame_index);
  EXPECT_EQ(camera_->counters().clock_jumps, 0U);
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
  EXPECT_EQ(camera_->counters().clock_jumps, 2U) << "one in each eye";
  EXPECT_EQ(camera_->counters().skipped_repeated, 0U);
}

TEST_F(LiveCamera, RefusesADeviceThatSetAnotherSizeAndPrintsBoth) {
  right_.width_px = 64;
  make();
  const Status opened = camera_->open();
  ASSERT_FALSE(opened);
  EXPECT_EQ(opened.error().code, ErrorCode::kUnsupported);
  EXPECT_THAT(opened.error().message, HasSubstr("48x32"));
  EXPECT_THAT(opened.error().message, HasSubstr("64x32"));
  EXPECT_EQ(camera_->state(), CameraState::kClosed);
}

TEST_F(LiveCamera, RefusesADeviceThatIsNotThere) {
  right_.plugged = false;
  make();
  EXPECT_EQ(camera_->open().error().code, ErrorCode::kNotFound);
  EXPECT_EQ(camera_->state(), CameraState::kClosed);
  right_.plugged = true;
  EXPECT_TRUE(camera_->open()) << "a failed open() leaves nothing behind";
}

TEST_F(LiveCamera, RefusesIllegalCallsWhileLostAndWhileRecovering) {
  begin();
  expect_frames(1);
  left_.plugged = false;
  EXPECT_FALSE(camera_->next(kTimeout));
  ASSERT_EQ(camera_->state(), CameraState::kLost);
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

TEST_F(LiveCamera, LearnsThatOneEyeIsAlwaysLate) {
  right_.phase_ns += 12 * kMs;  // Beyond the tolerance of 4 ms.
  begin();
  ASSERT_TRUE(frame_within(std::chrono::seconds(2)));
  expect_frames(30);
  EXPECT_NEAR(camera_->pairing().offset_ms, 12.0, 0.1);
  EXPECT_EQ(camera_->pairing().relearned, 1U);
}

TEST(LiveCameraConfig, NamesTheKeyThatIsWrong) {
  const auto refused = [](const std::function<void(LiveCameraConfig&)>& spoil) {
    LiveCameraConfig config = two_eyes();
    spoil(config);
    const Status status = config.validate();
    return status ? std::string() : status.error().message;
  };
  EXPECT_EQ(refused([](LiveCameraConfig& /*unchanged*/) {}), "");
  EXPECT_THAT(refused([](auto& c) { c.left.device = ""; }), HasSubstr("devices.left"));
  EXPECT_THAT(refused([](auto& c) { c.right->device = c.left.device; }), HasSubstr("devices.right"));
  EXPECT_THAT(refused([](auto& c) { c.right->width_px = 64; }), HasSubstr("64x32"));
  EXPECT_THAT(refused([](auto& c) { c.left.rate_hz = 0.0; }), HasSubstr("image.rate_hz"));
  EXPECT_THAT(refused([](auto& c) { c.right->exposure_us = -1.0; }), HasSubstr("image.exposure_us"));
  EXPECT_THAT(refused([](auto& c) {
                c.left.backend = c.right->backend = CaptureBackend::kLibcamera;
                c.left.trigger = c.right->trigger = TriggerMode::kExternal;
              }),
              HasSubstr("image.trigger"));
  EXPECT_THAT(refused([](auto& c) { c.left.buffers = 4; }), HasSubstr("image.buffers"));
  EXPECT_THAT(refused([](auto& c) { c.pair_tolerance_ms = 17.0; }), HasSubstr("pairing.tolerance_ms"));
  EXPECT_THAT(refused([](auto& c) { c.stall_timeout_ms = 0.0; }), HasSubstr("patience.stall_ms"));
  EXPECT_THAT(refused([](auto& c) { c.reopen_first_ms = 1e4; }), HasSubstr("patience.reopen_first_ms"));
  EXPECT_THAT(refused([](auto& c) {
                c.right.reset();
                c.left.width_px = 47;
              }),
              HasSubstr("image.width_px must be even"));
}

}  // namespace
}  // namespace kinetrace::hal::test
