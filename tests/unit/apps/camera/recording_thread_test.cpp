#include "camera/recording_thread.hpp"

#include <fstream>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "kinetrace/hal/dataset.hpp"
#include "temp_folder.hpp"

namespace kinetrace::app {
namespace {

constexpr int kWidth = 64;
constexpr int kHeight = 48;

class Recording : public ::testing::Test {
 protected:
  hal::RawRecorderConfig config() {
    hal::RigCalibration rig;
    rig.source = "test";
    rig.rectified = StereoGeometry{40, 40, 32, 24, 0.1, kWidth, kHeight};
    RawOutputOptions options;
    options.out = folder_.path() / "raw";
    options.container = true;
    options.keep_free_mib = 0;
    return raw_recorder_config(options, rig, 30.0);
  }
  Outcome<std::unique_ptr<RecordingThread>> make(const hal::RawRecorderConfig& config) {
    arena_.emplace(RecordingThread::required_bytes(config));
    return RecordingThread::create(config, *arena_);
  }
  StereoFrame frame(std::int64_t index) {
    std::fill(pixels_.begin(), pixels_.end(), static_cast<std::uint8_t>(index));
    const GrayView image{pixels_.data(), kWidth, kHeight, kWidth};
    return {index, index * 33'333'333, "a name that does not live", image, image};
  }

  test::TempFolder folder_;
  std::optional<Arena> arena_;
  std::vector<std::uint8_t> pixels_ = std::vector<std::uint8_t>(kWidth * kHeight);
};

TEST_F(Recording, WritesWhatItWasGivenInOrder) {
  {
    const auto thread = make(config()).value();
    for (int i = 0; i < 100; ++i) {
      thread->wait_for_room();
      thread->offer(frame(i));
    }
    thread->finish();
    EXPECT_EQ(thread->written(), 100);
    EXPECT_EQ(thread->dropped(), 0U);
    EXPECT_FALSE(thread->stopped_by());
    thread->offer(frame(100));
    thread->finish();
    EXPECT_EQ(thread->written(), 100) << "after the end nothing is taken";
  }
  const auto dataset =
      hal::open_dataset({.layout = hal::DatasetLayout::kContainer, .path = folder_.path() / "raw"}).value();
  ASSERT_EQ(dataset.frames.size(), 100U);
  EXPECT_EQ(dataset.frames[99].frame_index, 99);
}

TEST_F(Recording, EveryFrameIsWrittenOrCounted) {
  const auto thread = make(config()).value();
  for (int i = 0; i < 2000; ++i) {
    thread->offer(frame(i));
  }
  thread->finish();
  EXPECT_EQ(static_cast<std::uint64_t>(thread->written()) + thread->dropped(), 2000U);
  EXPECT_GT(thread->written(), 0);
}

TEST_F(Recording, PairsOfAnotherSizeAreDropped) {
  const auto thread = make(config()).value();
  StereoFrame small = frame(0);
  small.right.width /= 2;
  thread->offer(small);
  StereoFrame turned = frame(1);
  turned.left = turned.right = {pixels_.data(), kHeight, kWidth, kHeight};
  thread->offer(turned);
  thread->offer(frame(2));
  thread->finish();
  EXPECT_EQ(thread->dropped(), 2U);
  EXPECT_EQ(thread->written(), 1);
  EXPECT_FALSE(thread->stopped_by());
}

TEST_F(Recording, AFullDiskEndsItAndNothingElse) {
  hal::RawRecorderConfig greedy = config();
  greedy.keep_free_bytes = std::uint64_t{1} << 60U;
  const auto thread = make(greedy).value();
  for (int i = 0; i < 50; ++i) {
    thread->wait_for_room();
    thread->offer(frame(i));
  }
  thread->finish();
  ASSERT_TRUE(thread->stopped_by());
  EXPECT_EQ(thread->stopped_by()->code, ErrorCode::kIo);
  EXPECT_EQ(thread->written(), 0);
}

TEST_F(Recording, AFolderThatCannotBeUsedIsSaidBefore) {
  std::filesystem::create_directories(folder_.path() / "raw");
  std::ofstream(folder_.path() / "raw/x") << "x";
  const auto thread = make(config());
  ASSERT_FALSE(thread);
  EXPECT_EQ(thread.error().code, ExitCode::kCannotCreate);
}

}  // namespace
}  // namespace kinetrace::app
