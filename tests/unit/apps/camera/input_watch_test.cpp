// Warnings to the user, each once, about wrong images or masks of a camera or a recording.
#include "camera/input_watch.hpp"

#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "segmentation/mask_file_watch.hpp"
#include "wall_for_test.hpp"

namespace kinetrace::app {
namespace {

using testing::AllOf;
using testing::ElementsAre;
using testing::HasSubstr;

constexpr int kWidth = 320;
constexpr int kHeight = 240;

class InputWatchTest : public testing::Test {
 protected:
  /// Plays frames of a wall seen with this disparity until the watch ends the run.
  Status play(InputPolicy policy, double disparity_px, bool right_is_left = false) {
    Arena arena(hal::InputMonitor::required_bytes({}, kWidth, kHeight));
    InputWatch watch(hal::InputMonitor::create({}, kWidth, kHeight, arena).value(), PairingKeeper(nullptr), policy,
                     {"recording x", "rig.yaml"});
    for (int frame = 0; frame < 40; ++frame) {
      const auto left = hal::test::wall(kWidth, kHeight, 0.0, frame);
      const auto right = right_is_left ? left : hal::test::wall(kWidth, kHeight, disparity_px, frame);
      const GrayView left_view{left.data(), kWidth, kHeight, kWidth};
      const GrayView right_view{right.data(), kWidth, kHeight, kWidth};
      if (Status status = watch.process({frame, frame, {}, left_view, right_view},
                                        {frame, frame, {}, left_view, right_view, {}}, health_, warn_);
          !status) {
        return status;
      }
    }
    return {};
  }
  std::uint64_t noted(HealthReason reason) const { return health_.all()[static_cast<std::size_t>(reason)].count; }

  HealthMonitor health_;
  std::vector<std::string> said_;
  Warn warn_ = [this](const std::string& warning) { said_.push_back(warning); };
};

TEST_F(InputWatchTest, SaysNothingOfAGoodRig) {
  EXPECT_TRUE(play(InputPolicy::kStop, 24.0));
  EXPECT_THAT(said_, ElementsAre());
  EXPECT_EQ(health_.worst(), HealthState::kOk);
}

TEST_F(InputWatchTest, ExchangedCamerasEndTheRunByName) {
  const Status played = play(InputPolicy::kStop, -24.0);
  ASSERT_FALSE(played);
  EXPECT_EQ(played.error().code, ErrorCode::kBadFormat);
  EXPECT_THAT(played.error().message, AllOf(HasSubstr("recording x"), HasSubstr("exchanged")));
  EXPECT_EQ(noted(HealthReason::kViewsExchanged), 1U);
}

TEST_F(InputWatchTest, OrAreSaidOnceAndNotedAtEveryLook) {
  EXPECT_TRUE(play(InputPolicy::kWarn, -24.0));
  EXPECT_THAT(said_, ElementsAre(HasSubstr("exchanged")));
  EXPECT_EQ(noted(HealthReason::kViewsExchanged), 8U) << "ten looks in 40 frames, from the third on";
}

TEST_F(InputWatchTest, IdenticalCamerasHaveOneCauseAndOneLine) {
  EXPECT_TRUE(play(InputPolicy::kWarn, 0.0, true));
  EXPECT_THAT(said_, ElementsAre(HasSubstr("equal bit by bit")));
  EXPECT_EQ(play(InputPolicy::kStop, 0.0, true).error().code, ErrorCode::kBadFormat);
}

class MaskFileWatchTest : public testing::Test {
 protected:
  /// Status after a frame at `frames` tenths of a second.
  Status see(std::uint64_t frames, std::uint64_t missing, std::uint64_t unreadable) {
    FrameCounters counters;
    counters.frames = frames;
    counters.detection_frames_missing = missing;
    counters.mask_files_unreadable = unreadable;
    return watch_.process(counters, static_cast<std::int64_t>(frames) * 100'000'000, "m/1.png is torn", health_, warn_);
  }

  MaskFileWatch watch_{InputPolicy::kStop};
  HealthMonitor health_;
  std::vector<std::string> said_;
  Warn warn_ = [this](const std::string& warning) { said_.push_back(warning); };
};

TEST_F(MaskFileWatchTest, SaysOnceThatAFileIsDamaged) {
  EXPECT_TRUE(see(1, 0, 0) && see(2, 1, 1) && see(3, 2, 2) && see(30, 2, 2));
  EXPECT_THAT(said_, ElementsAre(HasSubstr("m/1.png is torn")));
  EXPECT_EQ(health_.worst(), HealthState::kDegraded);
  EXPECT_TRUE(watch_.finish("", warn_));
}

TEST_F(MaskFileWatchTest, EndsTheRunAfterTwoSecondsWithoutAMaskThatFits) {
  for (std::uint64_t frame = 1; frame <= 20; ++frame) {
    EXPECT_TRUE(see(frame, frame, frame)) << frame;
  }
  const Status status = see(21, 21, 21);
  ASSERT_FALSE(status);
  EXPECT_EQ(status.error().code, ErrorCode::kBadFormat);
  EXPECT_THAT(status.error().message, AllOf(HasSubstr("21 frames"), HasSubstr("m/1.png is torn")));
}

TEST_F(MaskFileWatchTest, WaitsForMasksThatBeginLater) {
  EXPECT_TRUE(see(1, 1, 0) && see(25, 25, 0));
  EXPECT_EQ(said_.size(), 1U);
  EXPECT_TRUE(see(26, 25, 0));
  EXPECT_TRUE(watch_.finish("m/1.png is not there", warn_));
}

TEST_F(MaskFileWatchTest, EndsARecordingWithoutAnyMaskAsUnusable) {
  EXPECT_TRUE(see(1, 1, 0) && see(5, 5, 0));
  EXPECT_EQ(watch_.finish("m/1.png is not there", warn_).error().code, ErrorCode::kBadFormat);
}

}  // namespace
}  // namespace kinetrace::app
