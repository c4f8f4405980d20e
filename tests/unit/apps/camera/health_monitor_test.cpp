#include "camera/health_monitor.hpp"

#include <gtest/gtest.h>

namespace kinetrace::app {
namespace {

using hal::CameraCounters;
using hal::CameraState;

class Health : public ::testing::Test {
 protected:
  void process(std::int64_t frame, BodyStatus pose = BodyStatus::kTracked) {
    monitor_.observe(CameraState::kStreaming, counters_);
    FrameEstimate estimate;
    estimate.frame_index = frame;
    estimate.camera.status = pose;
    monitor_.observe(estimate);
  }

  HealthMonitor monitor_;
  CameraCounters counters_;
};

TEST_F(Health, NamesWhatWasWrongLately) {
  process(0, BodyStatus::kInitializing);
  EXPECT_EQ(monitor_.condition(), Condition{});
  monitor_.note(HealthReason::kCameraStalled);
  process(1, BodyStatus::kLost);
  Condition expected{HealthState::kDegraded, {}};
  expected.reasons.set(static_cast<std::size_t>(HealthReason::kCameraStalled));
  expected.reasons.set(static_cast<std::size_t>(HealthReason::kPoseLost));
  EXPECT_EQ(monitor_.condition(), expected);
  process(2 + HealthMonitor::kRecentFrames);
  EXPECT_EQ(monitor_.condition(), Condition{});
}

TEST_F(Health, IsOkWhileNothingIsWrong) {
  EXPECT_EQ(monitor_.state(), HealthState::kOk);
  process(0, BodyStatus::kInitializing);
  process(1);
  EXPECT_EQ(monitor_.worst(), HealthState::kOk);
  EXPECT_TRUE(monitor_.entries().empty());
}

TEST_F(Health, WhatWasLostBeforeTheFirstFrameCountsFromThatOn) {
  counters_.gaps = 8;
  process(8);
  process(9);
  ASSERT_EQ(monitor_.entries().size(), 1U);
  EXPECT_EQ(monitor_.entries()[0].first_frame, 8);
  EXPECT_EQ(monitor_.entries()[0].last_frame, 8);
}

TEST_F(Health, IsDegradedForAWhileAfterEachTrouble) {
  process(0);
  process(1);
  counters_.gaps = 3;
  process(5);
  EXPECT_EQ(monitor_.state(), HealthState::kDegraded);
  // Noticed while frame 1 was the newest.
  for (std::int64_t frame = 6; frame <= 1 + HealthMonitor::kRecentFrames; ++frame) {
    process(frame);
    EXPECT_EQ(monitor_.state(), HealthState::kDegraded) << frame;
  }
  process(2 + HealthMonitor::kRecentFrames);
  EXPECT_EQ(monitor_.state(), HealthState::kOk);
  EXPECT_EQ(monitor_.worst(), HealthState::kDegraded);
  counters_.skipped_missing_side = 1;
  process(100);
  ASSERT_EQ(monitor_.entries().size(), 1U);
  const HealthEntry entry = monitor_.entries().front();
  EXPECT_EQ(entry.reason, HealthReason::kFramesLost);
  EXPECT_EQ(entry.count, 4U);
  EXPECT_EQ(entry.first_frame, 1);
  EXPECT_EQ(entry.last_frame, 2 + HealthMonitor::kRecentFrames);
}

TEST_F(Health, FollowsTheCamerasState) {
  process(0);
  monitor_.observe(CameraState::kStalled, counters_);
  EXPECT_EQ(monitor_.state(), HealthState::kDegraded);
  counters_.losses = 1;
  monitor_.observe(CameraState::kLost, counters_);
  EXPECT_EQ(monitor_.state(), HealthState::kLost);
  monitor_.observe(CameraState::kRecovering, counters_);
  EXPECT_EQ(monitor_.state(), HealthState::kDegraded);
  EXPECT_EQ(monitor_.camera(), CameraState::kRecovering);
  EXPECT_EQ(monitor_.worst(), HealthState::kLost);
}

TEST_F(Health, EveryCounterOfTheCameraHasAReason) {
  const std::vector<std::pair<std::uint64_t CameraCounters::*, HealthReason>> expected{
      {&CameraCounters::skipped_missing_side, HealthReason::kFramesLost},
      {&CameraCounters::gaps, HealthReason::kFramesLost},
      {&CameraCounters::skipped_unreadable, HealthReason::kFramesDamaged},
      {&CameraCounters::skipped_outdated, HealthReason::kFramesOutdated},
      {&CameraCounters::skipped_repeated, HealthReason::kFramesRepeated},
      {&CameraCounters::skipped_wrong_size, HealthReason::kFramesOfWrongSize},
      {&CameraCounters::clock_jumps, HealthReason::kClockJumped},
      {&CameraCounters::pairing_slips, HealthReason::kViewsOutOfStep},
      {&CameraCounters::pairing_moves, HealthReason::kViewsOutOfStep},
      {&CameraCounters::stream_restarts, HealthReason::kFramesLost},
      {&CameraCounters::stalls, HealthReason::kCameraStalled},
      {&CameraCounters::losses, HealthReason::kCameraLost}};
  for (const auto& [counter, reason] : expected) {
    HealthMonitor monitor;
    CameraCounters counters;
    counters.*counter = 2;
    monitor.observe(CameraState::kStreaming, counters);
    monitor.observe(CameraState::kStreaming, counters);
    ASSERT_EQ(monitor.entries().size(), 1U) << to_string(reason);
    EXPECT_EQ(monitor.entries().front().reason, reason);
    EXPECT_EQ(monitor.entries().front().count, 2U);
  }
}

TEST_F(Health, KnowsWhenTheCamerasOwnMotionWasNotFound) {
  process(0, BodyStatus::kPropagated);
  EXPECT_EQ(monitor_.state(), HealthState::kOk) << "the first frame has nothing to move from";
  process(1, BodyStatus::kLost);
  EXPECT_EQ(monitor_.state(), HealthState::kDegraded);
  EXPECT_EQ(monitor_.entries().front().reason, HealthReason::kPoseLost);
}

}  // namespace
}  // namespace kinetrace::app
