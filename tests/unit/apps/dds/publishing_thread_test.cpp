#include "dds/publishing_thread.hpp"

#include <atomic>
#include <chrono>
#include <mutex>
#include <thread>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "sample_results.hpp"

namespace kinetrace::app {
namespace {

using test::SampleResult;

class PublishingThreadTest : public testing::Test {
 protected:
  std::unique_ptr<PublishingThread> start(publishing::PublishConfig config) {
    config.domain = 10;
    arena_ = Arena(PublishingThread::required_bytes(config));
    auto made = PublishingThread::create(
        config, SampleResult::geometry(),
        [this](const std::string& line) {
          const std::lock_guard lock(mutex_);
          reported_.push_back(line);
        },
        arena_);
    EXPECT_TRUE(made) << made.error().message;
    return std::move(*made);
  }
  std::vector<std::string> reported() {
    const std::lock_guard lock(mutex_);
    return reported_;
  }
  static std::uint64_t counter(const PublishingThread& thread, const std::string& name) {
    for (const auto& [known, value] : thread.counters()) {
      if (known == name) {
        return value;
      }
    }
    return 12345;
  }

  Arena arena_;
  std::mutex mutex_;
  std::vector<std::string> reported_;
};

TEST_F(PublishingThreadTest, EveryFrameIsPublishedOrSuperseded) {
  const auto thread = start({});
  constexpr std::uint64_t kFrames = 50;
  for (std::uint64_t i = 0; i < kFrames; ++i) {
    thread->offer(SampleResult({}, static_cast<std::int64_t>(i)).result, 0);
  }
  thread->finish();
  EXPECT_EQ(counter(*thread, "dds_frames_offered"), kFrames);
  EXPECT_EQ(counter(*thread, "dds_frames") + counter(*thread, "dds_frames_superseded"), kFrames);
  EXPECT_GE(counter(*thread, "dds_frames"), 1U);
}

TEST_F(PublishingThreadTest, FinishingTwiceIsFinishingOnce) {
  const auto thread = start({});
  EXPECT_TRUE(thread->is_connected());
  thread->finish();
  thread->finish();
}

TEST_F(PublishingThreadTest, FramesWithoutALinkAreCountedAndReported) {
  publishing::PublishConfig config;
  config.interface = "nothere0";
  const auto thread = start(config);
  EXPECT_FALSE(thread->is_connected());
  thread->offer(SampleResult({}).result, 0);
  thread->finish();
  EXPECT_EQ(counter(*thread, "dds_frames_without_link"), 1U);
  EXPECT_THAT(reported(), testing::ElementsAre(testing::HasSubstr("interface nothere0 is not there")));
}

TEST_F(PublishingThreadTest, TakesNoMoreMemoryThanItAsksFor) {
  publishing::PublishConfig config;
  Arena small(PublishingThread::required_bytes(config) - 2 * Arena::kAlignment);
  const auto refused = PublishingThread::create(
      config, SampleResult::geometry(), [](const std::string&) {}, small);
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().code, ErrorCode::kCapacity);
}

}  // namespace
}  // namespace kinetrace::app
