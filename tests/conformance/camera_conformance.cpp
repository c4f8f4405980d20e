#include "camera_conformance.hpp"

#include <limits>

#include <gmock/gmock.h>

namespace kinetrace::hal::test {
namespace {

// Long: an emulated machine may be slow.
constexpr std::chrono::milliseconds kTimeout{10'000};

template <typename T>
void expect_illegal(const Result<T>& result, const StereoCamera& camera, CameraState unchanged) {
  ASSERT_FALSE(result);
  EXPECT_EQ(result.error().code, ErrorCode::kIllegalState);
  EXPECT_THAT(result.error().message, ::testing::HasSubstr(to_string(unchanged)));
  EXPECT_EQ(camera.state(), unchanged);
}

TEST_P(CameraConformance, BeginsClosedAndKnowsItsSize) {
  EXPECT_EQ(camera_.state(), CameraState::kClosed);
  ASSERT_TRUE(camera_.open());
  EXPECT_GT(camera_.info().width_px, 0);
  EXPECT_GT(camera_.info().height_px, 0);
  EXPECT_GT(camera_.info().nominal_rate_hz, 0.0);
  EXPECT_FALSE(camera_.info().name.empty());
}

TEST_P(CameraConformance, WalksThroughItsStates) {
  ASSERT_TRUE(camera_.open());
  EXPECT_EQ(camera_.state(), CameraState::kConfigured);
  ASSERT_TRUE(camera_.start());
  EXPECT_EQ(camera_.state(), CameraState::kStreaming);
  ASSERT_TRUE(camera_.next(kTimeout));
  EXPECT_EQ(camera_.state(), CameraState::kStreaming);
  ASSERT_TRUE(camera_.stop());
  EXPECT_EQ(camera_.state(), CameraState::kConfigured);
  camera_.close();
  EXPECT_EQ(camera_.state(), CameraState::kClosed);
}

TEST_P(CameraConformance, RefusesIllegalCallsWhileClosed) {
  expect_illegal(camera_.start(), camera_, CameraState::kClosed);
  expect_illegal(camera_.next(kTimeout), camera_, CameraState::kClosed);
  expect_illegal(camera_.stop(), camera_, CameraState::kClosed);
  expect_illegal(camera_.recover(), camera_, CameraState::kClosed);
}

TEST_P(CameraConformance, RefusesIllegalCallsWhileConfigured) {
  ASSERT_TRUE(camera_.open());
  expect_illegal(camera_.open(), camera_, CameraState::kConfigured);
  expect_illegal(camera_.next(kTimeout), camera_, CameraState::kConfigured);
  expect_illegal(camera_.stop(), camera_, CameraState::kConfigured);
  expect_illegal(camera_.recover(), camera_, CameraState::kConfigured);
}

TEST_P(CameraConformance, RefusesIllegalCallsWhileStreaming) {
  ASSERT_TRUE(camera_.open());
  ASSERT_TRUE(camera_.start());
  expect_illegal(camera_.open(), camera_, CameraState::kStreaming);
  expect_illegal(camera_.start(), camera_, CameraState::kStreaming);
  expect_illegal(camera_.recover(), camera_, CameraState::kStreaming);
  EXPECT_TRUE(camera_.next(kTimeout)) << "an illegal call must not disturb the stream";
}

TEST_P(CameraConformance, MayBeClosedInEveryState) {
  camera_.close();
  ASSERT_TRUE(camera_.open());
  camera_.close();
  ASSERT_TRUE(camera_.open());
  ASSERT_TRUE(camera_.start());
  camera_.close();
  EXPECT_EQ(camera_.state(), CameraState::kClosed);
  ASSERT_TRUE(camera_.open());
  ASSERT_TRUE(camera_.start());
  EXPECT_TRUE(camera_.next(kTimeout));
}

TEST_P(CameraConformance, FramesHaveTheAnnouncedSizeAndIncrease) {
  ASSERT_TRUE(camera_.open());
  ASSERT_TRUE(camera_.start());
  std::int64_t previous_index = -1;
  std::int64_t previous_time_ns = std::numeric_limits<std::int64_t>::min();
  for (int i = 0; i < 3; ++i) {
    const Result<StereoFrame> frame = camera_.next(kTimeout);
    ASSERT_TRUE(frame) << frame.error().message;
    for (const GrayView& image : {frame->left, frame->right}) {
      EXPECT_EQ(image.width, camera_.info().width_px);
      EXPECT_EQ(image.height, camera_.info().height_px);
      EXPECT_FALSE(image.empty());
    }
    EXPECT_NE(frame->left.data, frame->right.data);
    EXPECT_GT(frame->frame_index, previous_index);
    EXPECT_GT(frame->timestamp_ns, previous_time_ns);
    previous_index = frame->frame_index;
    previous_time_ns = frame->timestamp_ns;
  }
  EXPECT_EQ(camera_.counters().frames_delivered, 3U);
}

TEST_P(CameraConformance, CountersBeginAnewWithEachStart) {
  ASSERT_TRUE(camera_.open());
  for (int i = 0; i < 2; ++i) {
    ASSERT_TRUE(camera_.start());
    EXPECT_EQ(camera_.counters().frames_delivered, 0U);
    ASSERT_TRUE(camera_.next(kTimeout));
    EXPECT_EQ(camera_.counters().frames_delivered, 1U);
    ASSERT_TRUE(camera_.stop());
  }
}

TEST_P(CameraConformance, AStreamThatEndsStaysEnded) {
  ASSERT_TRUE(camera_.open());
  if (!camera_.info().frame_count) {
    GTEST_SKIP() << "a live camera has no end";
  }
  ASSERT_TRUE(camera_.start());
  std::int64_t frames = 0;
  while (camera_.next(kTimeout)) {
    ASSERT_LE(++frames, *camera_.info().frame_count);
  }
  EXPECT_EQ(camera_.next(kTimeout).error().code, ErrorCode::kEndOfStream);
  EXPECT_EQ(camera_.next(kTimeout).error().code, ErrorCode::kEndOfStream);
  EXPECT_EQ(camera_.state(), CameraState::kStreaming);
  ASSERT_TRUE(camera_.stop());
  ASSERT_TRUE(camera_.start());
  EXPECT_TRUE(camera_.next(kTimeout));
}

}  // namespace
}  // namespace kinetrace::hal::test
