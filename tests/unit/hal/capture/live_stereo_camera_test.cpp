// Pairing of images from two scripted devices, and handling of unpaired images.
#include <random>
#include <set>

#include <gtest/gtest.h>

#include "live_camera_for_test.hpp"

namespace kinetrace::hal::test {
namespace {

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
  begin_side_by_side();
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
  EXPECT_EQ(camera_->counters().gaps, 0U) << "of each, an image of one camera came";
  EXPECT_EQ(camera_->counters().skipped_unreadable, 1U);
  EXPECT_EQ(camera_->counters().skipped_missing_side, 2U);
}

TEST_F(LiveCamera, FramesThatBothCamerasLostAreGapsWhetherOrNotTheDriverCounts) {
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
        // Frames lost before the first pair belong to no pair.
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

TEST_F(LiveCamera, LearnsThatOneCameraIsAlwaysLate) {
  right_.phase_ns += 12 * kMs;  // Beyond the tolerance of 4 ms.
  begin();
  ASSERT_TRUE(frame_within(std::chrono::seconds(2)));
  expect_frames(30);
  EXPECT_NEAR(camera_->pairing().offset_ms, 12.0, 0.1);
  EXPECT_EQ(camera_->pairing().relearned, 1U);
}

}  // namespace
}  // namespace kinetrace::hal::test
