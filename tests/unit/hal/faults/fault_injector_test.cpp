#include "kinetrace/hal/fault_injector.hpp"

#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "scripted_camera.hpp"

namespace kinetrace::hal::test {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;

// The scripted camera never waits, so that this is never reached.
constexpr std::chrono::milliseconds kTimeout{10'000};

class Faulty : public ::testing::Test {
 protected:
  void begin(const std::string& faults, int frames = 10, std::chrono::milliseconds frame_takes = {}) {
    auto camera = std::make_unique<ScriptedCamera>();
    camera->frame_takes = frame_takes;
    camera->give_frames(0, frames - 1);
    camera_ = FaultInjector::create(std::move(camera), parse_faults(faults).value(), ScriptedCamera::kWidth,
                                    ScriptedCamera::kHeight, arena_)
                  .value();
    ASSERT_TRUE(camera_->open() && camera_->start());
  }
  /// Numbers of the delivered frames; -1 for a time-out, -2 for a loss (followed by a recovery).
  std::vector<std::int64_t> play(const std::string& faults, int frames = 10) {
    begin(faults, frames);
    std::vector<std::int64_t> came;
    for (;;) {
      const Result<StereoFrame> frame = camera_->next(kTimeout);
      if (!frame && frame.error().code == ErrorCode::kEndOfStream) {
        return came;
      }
      if (!frame && frame.error().code == ErrorCode::kDisconnected) {
        EXPECT_EQ(camera_->state(), CameraState::kLost);
        while (!camera_->recover()) {
          ++failed_attempts_;
        }
        EXPECT_EQ(camera_->state(), CameraState::kRecovering);
      }
      came.push_back(frame ? frame->frame_index : frame.error().code == ErrorCode::kTimeout ? -1 : -2);
    }
  }

  Arena arena_{std::size_t{1} << 20};
  std::unique_ptr<FaultInjector> camera_;
  int failed_attempts_ = 0;
};

TEST_F(Faulty, WithoutAPlanNothingHappens) {
  EXPECT_THAT(play("seed=3", 4), ElementsAre(0, 1, 2, 3));
  EXPECT_EQ(camera_->counters().frames_delivered, 4U);
}

TEST_F(Faulty, Drops) {
  EXPECT_THAT(play("drop@0,drop@3-5"), ElementsAre(1, 2, 6, 7, 8, 9));
  EXPECT_EQ(camera_->counters().gaps, 4U);
  EXPECT_EQ(camera_->counters().frames_delivered, 6U);
}

TEST_F(Faulty, Duplicates) {
  EXPECT_THAT(play("duplicate@2-3", 5), ElementsAre(0, 1, 2, 2, 3, 3, 4));
}

TEST_F(Faulty, Reorders) {
  EXPECT_THAT(play("reorder@2", 6), ElementsAre(0, 1, 3, 2, 4, 5));
}

TEST_F(Faulty, GivesOutWhatItHeldBackAtTheEnd) {
  EXPECT_THAT(play("reorder@5", 6), ElementsAre(0, 1, 2, 3, 4, 5));
  EXPECT_EQ(camera_->counters().frames_delivered, 6U);
}

TEST_F(Faulty, IsStuck) {
  EXPECT_THAT(play("stuck@2-4", 6), ElementsAre(0, 1, -1, -1, -1, 5));
  EXPECT_EQ(camera_->counters().stalls, 1U);
}

TEST_F(Faulty, IsUnpluggedForSomeFramesAndAttempts) {
  EXPECT_THAT(play("unplug@2-5:4", 8), ElementsAre(0, 1, -2, 6, 7));
  EXPECT_EQ(failed_attempts_, 4);
  EXPECT_EQ(camera_->counters().losses, 1U);
  EXPECT_EQ(camera_->counters().recoveries, 1U);
  begin("unplug@0");
  EXPECT_EQ(camera_->next(kTimeout).error().code, ErrorCode::kDisconnected);
  EXPECT_EQ(camera_->next(kTimeout).error().code, ErrorCode::kIllegalState);
  EXPECT_EQ(camera_->stop().error().code, ErrorCode::kIllegalState);
  camera_->close();
  EXPECT_EQ(camera_->state(), CameraState::kClosed);
}

TEST_F(Faulty, CutsOffOneCamera) {
  begin("corrupt@0-1:50");
  for (int i = 0; i < 3; ++i) {
    const StereoFrame frame = camera_->next(kTimeout).value();
    const auto is_cut = [](GrayView image) {
      return std::all_of(image.row(40), image.row(40) + image.width, [](std::uint8_t value) { return value == 0; });
    };
    EXPECT_EQ(is_cut(frame.left) != is_cut(frame.right), i < 2);
    EXPECT_NE(frame.left.at(5, 5), 0);
    EXPECT_NE(frame.right.at(5, 5), 0);
  }
}

TEST_F(Faulty, ShowsTheRightImageOfTheFrameBefore) {
  auto camera = std::make_unique<ScriptedCamera>();
  std::vector<std::vector<std::uint8_t>> pixels;
  for (std::uint8_t i = 0; i < 5; ++i) {
    pixels.emplace_back(ScriptedCamera::kWidth * ScriptedCamera::kHeight, i);
  }
  for (std::size_t i = 0; i < pixels.size(); ++i) {
    StereoFrame frame = camera->frame(static_cast<std::int64_t>(i));
    frame.left.data = frame.right.data = pixels[i].data();
    camera->give(frame);
  }
  camera_ = FaultInjector::create(std::move(camera), parse_faults("desync@2-3").value(), ScriptedCamera::kWidth,
                                  ScriptedCamera::kHeight, arena_)
                .value();
  ASSERT_TRUE(camera_->open() && camera_->start());
  for (const int right : {0, 1, 1, 2, 4}) {
    const StereoFrame frame = camera_->next(kTimeout).value();
    EXPECT_EQ(frame.left.at(0, 0), frame.frame_index);
    EXPECT_EQ(frame.right.at(0, 0), right);
  }
}

TEST_F(Faulty, ShiftsTheClockForGood) {
  begin("clock@2:-7.5", 5);
  for (int i = 0; i < 5; ++i) {
    EXPECT_EQ(camera_->next(kTimeout).value().timestamp_ns,
              i * ScriptedCamera::kPeriod_ns - (i >= 2 ? 7'500'000'000 : 0));
  }
}

TEST_F(Faulty, HalvesTheSize) {
  begin("size@1,reorder@1", 4);
  EXPECT_EQ(camera_->next(kTimeout).value().left.width, ScriptedCamera::kWidth);
  EXPECT_EQ(camera_->next(kTimeout).value().frame_index, 2);
  const StereoFrame small = camera_->next(kTimeout).value();
  EXPECT_EQ(small.frame_index, 1);
  EXPECT_EQ(small.left.width, ScriptedCamera::kWidth / 2);
  EXPECT_EQ(small.right.height, ScriptedCamera::kHeight / 2);
}

TEST_F(Faulty, TheSeedDecidesAndNothingElse) {
  const auto first = play("drop@0-999%30,seed=5", 1000);
  EXPECT_EQ(first, play("drop@0-999%30,seed=5", 1000));
  EXPECT_NE(first, play("drop@0-999%30,seed=6", 1000));
  EXPECT_NEAR(static_cast<double>(first.size()), 700.0, 60.0);
  EXPECT_EQ(play("drop@0-999%0", 1000).size(), 1000U);
}

TEST_F(Faulty, StartsAnew) {
  begin("drop@0");
  EXPECT_EQ(camera_->next(kTimeout).value().frame_index, 1);
  ASSERT_TRUE(camera_->stop() && camera_->start());
  EXPECT_EQ(camera_->next(kTimeout).value().frame_index, 3) << "the first frame after start() is dropped again";
}

TEST_F(Faulty, NothingOfAStreamOutlivesIt) {
  for (const char* plan : {"duplicate@0", "reorder@0,duplicate@1"}) {
    begin(plan);
    ASSERT_TRUE(camera_->next(kTimeout));
    camera_->close();
    EXPECT_EQ(camera_->next(kTimeout).error().code, ErrorCode::kIllegalState) << plan;
    begin(plan);
    ASSERT_TRUE(camera_->next(kTimeout));
    ASSERT_TRUE(camera_->stop());
    EXPECT_EQ(camera_->next(kTimeout).error().code, ErrorCode::kIllegalState) << plan;
  }
}

TEST_F(Faulty, NeverTakesLongerThanItMay) {
  constexpr std::chrono::milliseconds kFrameTakes(5);
  constexpr std::chrono::milliseconds kShortTimeout(30);
  for (const char* plan : {"drop@0-199", "unplug@0-199:0"}) {
    begin(plan, 200, kFrameTakes);
    if (camera_->next(kShortTimeout).error().code == ErrorCode::kDisconnected) {
      ASSERT_TRUE(camera_->recover());
    }
    EXPECT_EQ(camera_->next(kShortTimeout).error().code, ErrorCode::kTimeout) << plan << " is over after a second";
  }
}

TEST_F(Faulty, LeavesFramesAloneForWhichItHasNoRoom) {
  auto camera = std::make_unique<ScriptedCamera>();
  camera->give_frames(0, 3);
  camera_ = FaultInjector::create(std::move(camera), parse_faults("desync@0-3,corrupt@0-3,reorder@0-3").value(),
                                  ScriptedCamera::kWidth / 2, ScriptedCamera::kHeight, arena_)
                .value();
  ASSERT_TRUE(camera_->open() && camera_->start());
  for (int i = 0; i < 4; ++i) {
    const StereoFrame frame = camera_->next(kTimeout).value();
    EXPECT_EQ(frame.frame_index, i);
    EXPECT_EQ(frame.left.width, ScriptedCamera::kWidth);
  }
}

TEST_F(Faulty, SaysWhatIsWrongWithAPlan) {
  for (const char* wrong : {"", "explode@1", "drop", "drop@", "drop@-1", "drop@x", "drop@5-4", "drop@1:3", "drop@1%101",
                            "drop@1%nan", "clock@1:inf", "corrupt@1:0", "drop@1,", "seed=-1", "seed=x"}) {
    const auto plan = parse_faults(wrong);
    ASSERT_FALSE(plan) << wrong;
    EXPECT_EQ(plan.error().code, ErrorCode::kInvalidArgument);
    EXPECT_THAT(plan.error().message, HasSubstr("KIND@FIRST")) << wrong;
  }
}

TEST(FaultInjector, AsksForTheMemoryItTakes) {
  Arena small(FaultInjector::required_bytes(64, 48) - 1);
  EXPECT_EQ(FaultInjector::create(std::make_unique<ScriptedCamera>(), {}, 64, 48, small).error().code,
            ErrorCode::kCapacity);
  Arena enough(FaultInjector::required_bytes(64, 48));
  EXPECT_TRUE(FaultInjector::create(std::make_unique<ScriptedCamera>(), {}, 64, 48, enough));
}

}  // namespace
}  // namespace kinetrace::hal::test
