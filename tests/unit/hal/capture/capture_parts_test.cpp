// The small parts that capture backends share.
#include <filesystem>
#include <fstream>
#include <limits>
#include <poll.h>
#include <thread>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "capture/capture_device.hpp"
#include "capture/completed_queue.hpp"
#include "capture/frame_wait.hpp"
#include "capture/rate_meter.hpp"
#include "capture/settings_check.hpp"
#include "capture/v4l2/v4l2_node.hpp"
#include "synchronization/sequence_unwrapper.hpp"
#include "temp_folder.hpp"
#include "util/monotonic_time.hpp"

namespace kinetrace::hal {
namespace {

constexpr std::uint32_t kLast = std::numeric_limits<std::uint32_t>::max();
constexpr std::int64_t kWrap = std::int64_t{1} << 32;

/// The first error of `images` images that report `got`; empty if there is none.
std::string error_after(int images, const CaptureSettings& asked, const CaptureSettings& got) {
  SettingsCheck check(asked);
  Status status;
  for (int i = 0; i < images && status; ++i) {
    status = check.check("camera", got);
  }
  return status ? std::string() : status.error().message;
}

TEST(SettingsCheck, AcceptsWhatIsCloseOrNotReported) {
  const CaptureSettings asked{.exposure_us = 5000.0, .gain = 4.0, .period_us = 33'333.0};
  EXPECT_EQ(error_after(100, asked, {}), "");
  EXPECT_EQ(error_after(100, asked, {.exposure_us = 4980.0, .gain = 4.1, .period_us = 33'366.0}), "");
  EXPECT_EQ(error_after(100, {}, {.exposure_us = 1.0, .gain = 9.0, .period_us = 1.0}), "") << "automatic";
}

TEST(SettingsCheck, FindsWhatTheCameraDidNotSetAndPrintsBoth) {
  const CaptureSettings asked{.exposure_us = 5000.0, .gain = 4.0, .period_us = 33'333.0};
  EXPECT_THAT(error_after(100, asked, {.exposure_us = 3300.0}),
              ::testing::AllOf(::testing::HasSubstr("exposure_us 5000"), ::testing::HasSubstr("set 3300")));
  EXPECT_THAT(error_after(100, asked, {.gain = 1.0}), ::testing::HasSubstr("gain 4, the camera set 1"));
  EXPECT_THAT(error_after(100, asked, {.period_us = 50'000.0}), ::testing::HasSubstr("set 50000"));
}

TEST(SettingsCheck, WaitsForSettingsToReachTheSensorAndAnewAfterEachStart) {
  const CaptureSettings asked{.exposure_us = 5000.0};
  const CaptureSettings old{.exposure_us = 100.0};
  EXPECT_EQ(error_after(8, asked, old), "");
  EXPECT_NE(error_after(9, asked, old), "");
  SettingsCheck check(asked);
  for (int i = 0; i < 20; ++i) {
    check.reset();
    EXPECT_TRUE(check.check("camera", old));
  }
}

TEST(SequenceUnwrapper, BeginsWhereTheDriverDoes) {
  EXPECT_EQ(SequenceUnwrapper().unwrap(0), 0);
  EXPECT_EQ(SequenceUnwrapper().unwrap(kLast), kWrap - 1);
}

TEST(SequenceUnwrapper, ContinuesBeyond32BitsEveryTime) {
  SequenceUnwrapper unwrapper;
  constexpr std::uint32_t kStep = 1U << 30U;
  std::int64_t expected = 0;
  std::uint32_t sequence = 0;
  EXPECT_EQ(unwrapper.unwrap(sequence), 0);
  for (int i = 0; i < 20; ++i) {
    sequence += kStep;
    expected += kStep;
    EXPECT_EQ(unwrapper.unwrap(sequence), expected);
  }
  EXPECT_GT(expected, 4 * kWrap);
}

TEST(SequenceUnwrapper, FollowsStepsBackAcrossTheWrap) {
  SequenceUnwrapper unwrapper;
  EXPECT_EQ(unwrapper.unwrap(kLast), kWrap - 1);
  EXPECT_EQ(unwrapper.unwrap(1), kWrap + 1);
  EXPECT_EQ(unwrapper.unwrap(kLast), kWrap - 1);
}

TEST(SequenceUnwrapper, ForgetsOnReset) {
  SequenceUnwrapper unwrapper;
  EXPECT_EQ(unwrapper.unwrap(kLast), kWrap - 1);
  unwrapper.reset();
  EXPECT_EQ(unwrapper.unwrap(3), 3);
}

TEST(V4l2Nodes, ThatCannotBeOpenedAreNamedWithTheReason) {
  const kinetrace::test::TempFolder folder;
  std::filesystem::create_directory(folder.path() / "video3");  // No user can open it for writing.
  std::ofstream(folder.path() / "video4") << "not a device";    // Writable, but no device.
  std::filesystem::create_symlink("gone", folder.path() / "video5");
  std::filesystem::create_directory(folder.path() / "videos");
  const std::vector<Error> problems = unreadable_v4l2_nodes(folder.path().string());
  ASSERT_EQ(problems.size(), 1U);
  EXPECT_THAT(problems[0].message, ::testing::HasSubstr((folder.path() / "video3").string() + ": open: "));
  EXPECT_TRUE(unreadable_v4l2_nodes((folder.path() / "nowhere").string()).empty());
}

TEST(MonotonicTime, TakesOffTheTimeAsleep) {
  constexpr std::int64_t kAsleep_ns = 3'600'000'000'000;
  constexpr std::int64_t kNow_ns = 50'000'000'000;
  const ClockReading now{kNow_ns, kNow_ns + kAsleep_ns};
  EXPECT_EQ(to_monotonic_ns(now.boottime_ns - 40, now), kNow_ns - 40);
}

TEST(MonotonicTime, LeavesStampsThatAreMonotonicAlready) {
  constexpr std::int64_t kNow_ns = 50'000'000'000;
  const ClockReading slept{kNow_ns, kNow_ns + 3'600'000'000'000};
  EXPECT_EQ(to_monotonic_ns(kNow_ns - 40, slept), kNow_ns - 40);
  const ClockReading never_slept{kNow_ns, kNow_ns};
  EXPECT_EQ(to_monotonic_ns(kNow_ns - 40, never_slept), kNow_ns - 40);
}

bool is_readable(const CompletedQueue& queue) {
  return wait_readable(queue.wait_fd(), std::chrono::milliseconds(0));
}

TEST(CompletedQueue, HandsOutBySequenceWhateverTheOrderOfCompletion) {
  CompletedQueue queue(4);
  EXPECT_FALSE(queue.pop());
  for (const int sequence : {7, 5, 6}) {
    queue.push({.slot = sequence - 5, .sequence = sequence});
  }
  for (const int sequence : {5, 6, 7}) {
    const auto item = queue.pop();
    ASSERT_TRUE(item);
    EXPECT_EQ(item->sequence, sequence);
    EXPECT_EQ(item->slot, sequence - 5);
  }
  EXPECT_FALSE(queue.pop());
}

TEST(CompletedQueue, IsReadableExactlyWhileThereIsSomething) {
  CompletedQueue queue(4);
  EXPECT_FALSE(is_readable(queue));
  queue.push({0, 0});
  queue.push({1, 1});
  EXPECT_TRUE(is_readable(queue));
  EXPECT_TRUE(queue.pop());
  EXPECT_TRUE(is_readable(queue));
  EXPECT_TRUE(queue.pop());
  EXPECT_FALSE(is_readable(queue));
  queue.push({0, 2});
  queue.clear();
  EXPECT_FALSE(is_readable(queue));
}

TEST(CompletedQueue, HoldsItsCapacityAndNoMore) {
  CompletedQueue queue(2);
  for (int i = 0; i < 3; ++i) {
    queue.push({i, i});
  }
  EXPECT_TRUE(queue.pop());
  EXPECT_TRUE(queue.pop());
  EXPECT_FALSE(queue.pop());
}

TEST(CompletedQueue, StaysReadableOnceItsSourceHasGone) {
  CompletedQueue queue(2);
  queue.push({0, 0});
  queue.end();
  EXPECT_TRUE(queue.pop()) << "what was finished before is still delivered";
  EXPECT_FALSE(queue.pop());
  EXPECT_TRUE(queue.ended());
  EXPECT_TRUE(is_readable(queue));
  queue.clear();
  EXPECT_TRUE(is_readable(queue));
}

TEST(CompletedQueue, WakesAWaitingThread) {
  CompletedQueue queue(2);
  std::thread other([&queue] { queue.push({1, 8}); });
  EXPECT_TRUE(wait_readable(queue.wait_fd(), std::chrono::seconds(60)));
  other.join();
  EXPECT_EQ(queue.pop()->sequence, 8);
}

TEST(CaptureDevices, ABackendThatIsNotBuiltInIsNamedWithItsRemedy) {
  CaptureConfig config;
  config.backend = CaptureBackend::kLibcamera;
  config.device = "imx219";
  const auto device = make_capture_device(config);
  ASSERT_FALSE(device);
  EXPECT_EQ(device.error().code, ErrorCode::kUnsupported);
  EXPECT_THAT(device.error().message,
              ::testing::AllOf(::testing::HasSubstr("imx219"), ::testing::HasSubstr("KINETRACE_WITH_LIBCAMERA")));
}

TEST(CaptureDevices, AV4l2DeviceThatIsNotThereIsNotFound) {
  CaptureConfig config;
  for (const char* name : {"/dev/no-such-camera", "usb-nowhere-1"}) {
    config.device = name;
    const auto device = make_capture_device(config);
    ASSERT_TRUE(device);
    const Status opened = (*device)->open();
    ASSERT_FALSE(opened);
    EXPECT_EQ(opened.error().code, ErrorCode::kNotFound);
    EXPECT_EQ((*device)->wait_fd(), -1);
    for (const Status& status : {(*device)->start(), (*device)->stop()}) {
      ASSERT_FALSE(status);
      EXPECT_EQ(status.error().code, ErrorCode::kIllegalState);
    }
    EXPECT_EQ((*device)->next(std::chrono::milliseconds(0)).error().code, ErrorCode::kIllegalState);
  }
}

TEST(CaptureDevices, AFileThatIsNoVideoDeviceIsRefused) {
  CaptureConfig config;
  config.device = "/dev/null";
  const Status opened = make_capture_device(config).value()->open();
  ASSERT_FALSE(opened);
  EXPECT_EQ(opened.error().code, ErrorCode::kUnsupported);
}

}  // namespace
}  // namespace kinetrace::hal
