// A live camera on two scripted devices.
#pragma once

#include <chrono>
#include <cstdint>
#include <optional>

#include <gtest/gtest.h>

#include "fake_capture.hpp"
#include "kinetrace/core/arena.hpp"
#include "kinetrace/hal/live_stereo_camera.hpp"

namespace kinetrace::hal::test {

inline constexpr std::chrono::milliseconds kTimeout{100};

/// 48x32, at /dev/video0 and /dev/video2.
inline LiveCameraConfig small_cameras() {
  return live_config("/dev/video0", "/dev/video2", 48, 32);
}

class LiveCamera : public ::testing::Test {
 protected:
  void make(const LiveCameraConfig& config = small_cameras()) {
    arena_.emplace(LiveStereoCamera::required_bytes(config) + Arena::kAlignment);
    camera_.emplace(LiveStereoCamera::create(config, *arena_, machine_).value());
  }
  void begin(const LiveCameraConfig& config = small_cameras()) {
    make(config);
    ASSERT_TRUE(camera_->open() && camera_->start());
  }
  /// The left device delivers both views side by side.
  void begin_side_by_side() {
    left_.side_by_side = true;
    LiveCameraConfig config = small_cameras();
    config.right.reset();
    begin(config);
  }
  /// Calls next() until a frame or an error other than kTimeout, for at most this long.
  Result<StereoFrame> frame_within(std::chrono::milliseconds duration) {
    const std::int64_t until_ns = machine_.now_ns() + std::chrono::nanoseconds(duration).count();
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
  /// Unplugs a device that is in use.
  void lose(FakeSensor& sensor) {
    sensor.plugged = false;
    const Result<StereoFrame> lost = camera_->next(kTimeout);
    ASSERT_FALSE(lost);
    EXPECT_EQ(lost.error().code, ErrorCode::kDisconnected);
    EXPECT_EQ(camera_->state(), CameraState::kLost);
  }

  FakeMachine machine_;
  FakeSensor& left_ = machine_.add({.path = "/dev/video0", .stable_id = "usb-1"});
  FakeSensor& right_ = machine_.add({.path = "/dev/video2", .stable_id = "usb-2"});
  std::optional<Arena> arena_;
  std::optional<LiveStereoCamera> camera_;
};

}  // namespace kinetrace::hal::test
