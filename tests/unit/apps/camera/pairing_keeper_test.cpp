// A nodding camera before a wall with one late view: only the images show the delay, which must be corrected.
#include "camera/pairing_keeper.hpp"

#include <cmath>
#include <cstdlib>
#include <optional>

#include <gtest/gtest.h>

#include "fake_capture.hpp"
#include "wall_for_test.hpp"

namespace kinetrace::app {
namespace {

using hal::test::FakeMachine;
using hal::test::FakeSensor;

constexpr int kWidth = 320;
constexpr int kHeight = 240;
constexpr double kDisparity = 24.0;
constexpr std::chrono::milliseconds kTimeout{200};

double nod(int shot) {
  return 6.0 * std::sin(shot * 0.9);
}

/// Plays the camera, and draws each frame's images as a nodding rig sees them at the frame's shots.
class NoddingRig {
 public:
  explicit NoddingRig(bool side_by_side = false) : left_(machine_.add({.path = "l", .stable_id = "l"})) {
    left_.side_by_side = side_by_side;
    const hal::LiveCameraConfig config = hal::test::live_config("l", side_by_side ? "" : "r", 64, 32);
    camera_.emplace(hal::LiveStereoCamera::create(config, arena_, machine_).value());
    monitor_.emplace(hal::SyncMonitor::create({}, kWidth, kHeight, arena_).value());
    keeper_.emplace(&*camera_);
    EXPECT_TRUE(camera_->open() && camera_->start());
  }

  FakeSensor& right() { return right_; }
  const hal::CameraCounters& counters() const { return camera_->counters(); }
  std::uint64_t noted() const { return health_.entries().empty() ? 0 : health_.entries()[0].count; }

  /// Number of frames, among `frames`, whose views show different moments.
  int count_unsynchronised(int frames, int later_in_left_half = 0) {
    int unsynchronised = 0;
    for (int i = 0; i < frames; ++i) {
      const auto frame = camera_->next(kTimeout);
      if (!frame) {
        ADD_FAILURE() << frame.error().message;
        return frames;
      }
      const int left_shot = frame->left.at(0, 0) - later_in_left_half;
      const int right_shot = frame->right.at(0, 0) - (camera_->info().width_px < 64 ? 100 : 0);
      unsynchronised += left_shot != right_shot ? 1 : 0;
      look(*frame, left_shot, right_shot);
    }
    return unsynchronised;
  }

 private:
  void look(const StereoFrame& frame, int left_shot, int right_shot) {
    const auto left = hal::test::wall(kWidth, kHeight, 0.0, nod(left_shot));
    const auto right = hal::test::wall(kWidth, kHeight, kDisparity, nod(right_shot));
    const bool is_new = monitor_->process({.frame_index = frame.frame_index,
                                           .timestamp_ns = frame.timestamp_ns,
                                           .name = {},
                                           .left = {left.data(), kWidth, kHeight, kWidth},
                                           .right = {right.data(), kWidth, kHeight, kWidth},
                                           .geometry = {}});
    if (is_new && keeper_->process(monitor_->report(), health_)) {
      monitor_->restart();
    }
  }

  FakeMachine machine_;
  FakeSensor& left_;
  FakeSensor& right_ = machine_.add({.path = "r", .stable_id = "r"});
  Arena arena_{std::size_t{4} << 20U};
  std::optional<hal::LiveStereoCamera> camera_;
  std::optional<hal::SyncMonitor> monitor_;
  std::optional<PairingKeeper> keeper_;
  HealthMonitor health_;
};

TEST(PairingKeeper, LeavesCamerasAloneThatAreInStep) {
  NoddingRig rig;
  EXPECT_EQ(rig.count_unsynchronised(80), 0);
  EXPECT_EQ(rig.counters().pairing_moves, 0U);
  EXPECT_EQ(rig.noted(), 0U);
}

TEST(PairingKeeper, MendsACameraThatIsOneFrameLateAndKeepsAccountOfIt) {
  for (const int lag : {1, -1}) {
    NoddingRig rig;
    rig.right().lag_shots = lag;
    EXPECT_EQ(rig.count_unsynchronised(20), 20) << "not yet sure";
    EXPECT_EQ(rig.counters().pairing_moves, 0U);
    EXPECT_LE(rig.count_unsynchronised(40), 20);
    EXPECT_EQ(rig.count_unsynchronised(60), 0) << "right view late by " << lag;
    EXPECT_EQ(rig.counters().pairing_moves, 1U);
    EXPECT_EQ(rig.counters().skipped_missing_side, 1U) << "the one image without a partner";
    EXPECT_EQ(rig.counters().gaps, 0U);
    EXPECT_GE(rig.noted(), 4U);
  }
}

TEST(PairingKeeper, MendsTheWayBackToo) {
  NoddingRig rig;
  rig.right().lag_shots = 1;
  static_cast<void>(rig.count_unsynchronised(60));
  EXPECT_EQ(rig.count_unsynchronised(20), 0);
  rig.right().lag_shots = 0;
  static_cast<void>(rig.count_unsynchronised(60));
  EXPECT_EQ(rig.count_unsynchronised(20), 0);
  EXPECT_EQ(rig.counters().pairing_moves, 2U);
}

TEST(PairingKeeper, OnlyNotesWhatCannotBeMended) {
  NoddingRig rig(true);
  EXPECT_EQ(rig.count_unsynchronised(80, 1), 80) << "one image has both views";
  EXPECT_EQ(rig.counters().pairing_moves, 0U);
  EXPECT_GE(rig.noted(), 8U);
}

}  // namespace
}  // namespace kinetrace::app
