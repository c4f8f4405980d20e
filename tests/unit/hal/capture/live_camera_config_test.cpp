// Refusals of a live camera: bad configurations, and devices that do not match them.
#include <functional>
#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "live_camera_for_test.hpp"

namespace kinetrace::hal::test {
namespace {

using ::testing::HasSubstr;

TEST(LiveCameraConfig, NamesTheKeyThatIsWrong) {
  const auto refused = [](const std::function<void(LiveCameraConfig&)>& spoil) {
    LiveCameraConfig config = small_cameras();
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
  EXPECT_THAT(refused([](auto& c) { c.stall_timeout_ms = 0.0; }), HasSubstr("timeouts.stall_ms"));
  EXPECT_THAT(refused([](auto& c) { c.reopen_first_ms = 1e4; }), HasSubstr("timeouts.reopen_first_ms"));
  EXPECT_THAT(refused([](auto& c) {
                c.right.reset();
                c.left.width_px = 47;
              }),
              HasSubstr("image.width_px must be even"));
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

TEST_F(LiveCamera, AnUnreportedRateIsMeasuredAndMustBeTheRequestedOne) {
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
  EXPECT_THAT(frame.error().message, HasSubstr("right camera"));
  EXPECT_THAT(frame.error().message, HasSubstr("asked for 30.303 Hz, the device delivers 15.1515 Hz"));
}

}  // namespace
}  // namespace kinetrace::hal::test
