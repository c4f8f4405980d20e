// A stereo camera made of the kernel's two test cameras, under faults of their driver.
#include <thread>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "capture.hpp"
#include "kinetrace/core/allocation_counter.hpp"
#include "live_bench.hpp"
#include "vivid.hpp"

namespace kinetrace::hal::test {
namespace {

constexpr int kVeryMany = 300;

class VividStereo : public ::testing::Test {
 protected:
  void SetUp() override {
    ASSERT_TRUE(camera_.open());
    ASSERT_TRUE(camera_.start());
    ASSERT_TRUE(frame());
  }

  /// The next frame, later than all before.
  Result<StereoFrame> frame() {
    Result<StereoFrame> next = camera_.next(kMaxLateFrames);
    if (next) {
      EXPECT_GT(next->frame_index, index_);
      EXPECT_GT(next->timestamp_ns, time_ns_);
      index_ = next->frame_index;
      time_ns_ = next->timestamp_ns;
    }
    return next;
  }
  /// Takes frames until `wanted(counters)`.
  template <typename Wanted>
  [[nodiscard]] bool comes(Wanted wanted) {
    for (int i = 0; i < kVeryMany; ++i) {
      const auto next = frame();
      if (!next) {
        ADD_FAILURE() << next.error().message;
        return false;
      }
      if (wanted(camera_.counters())) {
        return true;
      }
    }
    return false;
  }
  /// Takes frames until there is none.
  [[nodiscard]] Error last_error() {
    for (int i = 0; i < kVeryMany; ++i) {
      if (const auto next = frame(); !next) {
        return next.error();
      }
    }
    return {ErrorCode::kInternal, "the stream continues"};
  }

  VividControls left_{kVividLeft};
  VividControls right_{kVividRight};
  LiveBench bench_{live_config(vivid_config(kVividLeft), vivid_config(kVividRight))};
  StereoCamera& camera_ = bench_.camera();
  std::int64_t index_ = -1;
  std::int64_t time_ns_ = -1;
};

TEST_F(VividStereo, EachCameraShowsItsOwnDevice) {
  constexpr int kBlack = 5;
  constexpr int kWhite = 6;
  left_.set("Test Pattern", kBlack);
  right_.set("Test Pattern", kWhite);
  for (int i = 0; i < kVeryMany; ++i) {
    const auto next = frame();
    ASSERT_TRUE(next) << next.error().message;
    const int left = next->left.at(160, 90);
    const int right = next->right.at(160, 90);
    if (left < 30 && right > 220) {
      return;
    }
  }
  ADD_FAILURE() << "black left and white right never came";
}

TEST_F(VividStereo, DroppedFramesAreCountedAndPairsContinue) {
  right_.set("Percentage of Dropped Buffers", 50);
  EXPECT_TRUE(comes([](const CameraCounters& counters) { return counters.skipped_missing_side > 0; }));
  left_.set("Percentage of Dropped Buffers", 50);
  EXPECT_TRUE(comes([](const CameraCounters& counters) { return counters.gaps > 0; })) << "both lost the same frame";
}

TEST_F(VividStereo, AFlaggedBufferIsSkippedAndCounted) {
  left_.set("Inject V4L2_BUF_FLAG_ERROR", 1);
  EXPECT_TRUE(comes([](const CameraCounters& counters) { return counters.skipped_unreadable > 0; }));
  EXPECT_TRUE(frame());
}

TEST_F(VividStereo, RefusedBuffersDisturbNothing) {
  // If each refusal lost a buffer, none would be left.
  for (int i = 0; i < 12; ++i) {
    right_.set("Inject VIDIOC_QBUF Error", 1);
    const auto next = frame();
    ASSERT_TRUE(next) << next.error().message;
  }
}

TEST_F(VividStereo, AFatalErrorOfOneCameraIsMended) {
  left_.set("Inject Fatal Streaming Error", 1);
  for (int i = 0; i < 10; ++i) {
    const auto next = frame();
    ASSERT_TRUE(next) << next.error().message;
  }
  EXPECT_EQ(camera_.counters().losses, 0U);
  EXPECT_EQ(camera_.counters().stream_restarts, 1U) << "of one camera, once";
}

TEST_F(VividStereo, AStuckCameraEndsPairsIsNamedAndComesBack) {
  right_.set("Percentage of Dropped Buffers", 100);
  Error error = last_error();
  EXPECT_EQ(error.code, ErrorCode::kDisconnected);
  EXPECT_THAT(error.message, ::testing::HasSubstr("right camera"));
  EXPECT_EQ(camera_.state(), CameraState::kLost);
  right_.set("Percentage of Dropped Buffers", 0);
  for (int attempt = 0; attempt < kVeryMany && !camera_.recover(); ++attempt) {
    std::this_thread::sleep_for(std::chrono::milliseconds(50));
  }
  ASSERT_EQ(camera_.state(), CameraState::kRecovering);
  EXPECT_TRUE(frame());
  EXPECT_EQ(camera_.state(), CameraState::kStreaming);
}

TEST_F(VividStereo, ADisconnectedCameraIsALossThatNamesIt) {
  left_.set("Disconnect", 1);
  const Error error = last_error();
  EXPECT_EQ(error.code, ErrorCode::kDisconnected);
  EXPECT_THAT(error.message, ::testing::HasSubstr("left camera"));
  EXPECT_EQ(camera_.state(), CameraState::kLost);
  Status away = camera_.recover();
  for (int i = 0; i < kVeryMany && !away && away.error().message.find("not yet due") != std::string::npos; ++i) {
    std::this_thread::sleep_for(std::chrono::milliseconds(50));
    away = camera_.recover();
  }
  ASSERT_FALSE(away) << "the driver keeps it away while somebody has it open";
  EXPECT_THAT(away.error().message, ::testing::HasSubstr(kVividLeft));
}

TEST_F(VividStereo, FramesTakeNoMemoryOfOurOwn) {
  ASSERT_TRUE(allocation_counting_available());
  int frames = 0;
  const AllocationCounts before = allocation_counts();
  for (int i = 0; i < 30; ++i) {
    frames += camera_.next(kMaxLateFrames) ? 1 : 0;
  }
  const AllocationCounts after = allocation_counts();
  EXPECT_EQ(frames, 30);
  EXPECT_EQ(after.own, before.own);
}

TEST_F(VividStereo, StampsThatJumpFarAheadDoNotReachTheFrames) {
  left_.set("Wrap Timestamp", 1);  // From its next start on it stamps with the last seconds of a 32-bit clock.
  ASSERT_TRUE(camera_.stop());
  ASSERT_TRUE(camera_.start());
  index_ = -1;
  const std::int64_t before_ns = time_ns_;
  for (int i = 0; i < 5; ++i) {
    const auto next = frame();
    ASSERT_TRUE(next) << next.error().message;
  }
  constexpr std::int64_t kFarAhead_ns = 3'600'000'000'000;
  EXPECT_GT(time_ns_, before_ns);
  EXPECT_LT(time_ns_, before_ns + kFarAhead_ns);
  EXPECT_GE(camera_.counters().clock_jumps, 1U);
}

}  // namespace
}  // namespace kinetrace::hal::test
