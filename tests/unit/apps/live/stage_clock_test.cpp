// Stage times, on a simulated clock.
#include "live/stage_clock.hpp"

#include <chrono>

#include <gtest/gtest.h>

namespace kinetrace::app {
namespace {

struct HandClock {
  using duration = std::chrono::milliseconds;
  using time_point = std::chrono::time_point<HandClock, duration>;
  static time_point now() noexcept { return time_point(duration(now_ms)); }
  static inline int now_ms = 0;
};

void pass(int ms) {
  HandClock::now_ms += ms;
}

double max_ms(const BasicStageClock<HandClock>& clock, Stage stage) {
  return clock.stage_times()[static_cast<std::size_t>(stage)].second.max_ms;
}

TEST(StageClock, FrameTimeLeavesOutDecodingBeforeAndWithin) {
  BasicStageClock<HandClock> clock;
  clock.enter(Stage::kCapture);
  pass(30);
  clock.leave(Stage::kCapture);
  pass(5);
  clock.begin_frame();
  clock.enter(Stage::kRectify);
  pass(2);
  clock.leave(Stage::kRectify);
  pass(1);
  clock.enter(Stage::kCapture);
  pass(7);
  clock.leave(Stage::kCapture);
  clock.end_frame();
  EXPECT_EQ(clock.frame_time().count, 1U);
  EXPECT_DOUBLE_EQ(clock.frame_time().max_ms, 3.0);
  EXPECT_DOUBLE_EQ(max_ms(clock, Stage::kCapture), 37.0);
  EXPECT_DOUBLE_EQ(max_ms(clock, Stage::kRectify), 2.0);
}

TEST(StageClock, NestedStagesAreNotCountedTwice) {
  BasicStageClock<HandClock> clock;
  clock.begin_frame();
  clock.enter(Stage::kSegment);
  pass(1);
  clock.enter(Stage::kCapture);
  pass(10);
  clock.leave(Stage::kCapture);
  pass(2);
  clock.leave(Stage::kSegment);
  clock.end_frame();
  EXPECT_DOUBLE_EQ(max_ms(clock, Stage::kSegment), 3.0);
  EXPECT_DOUBLE_EQ(clock.frame_time().max_ms, 3.0);
}

TEST(StageClock, AStageEnteredAgainInAFrameCountsOnceWithTheSum) {
  BasicStageClock<HandClock> clock;
  clock.begin_frame();
  for (int body = 0; body < 3; ++body) {
    const StageScope scope(&clock, Stage::kSfm);
    pass(4);
  }
  clock.end_frame();
  clock.begin_frame();
  clock.end_frame();
  EXPECT_DOUBLE_EQ(max_ms(clock, Stage::kSfm), 12.0);
  EXPECT_EQ(clock.stage_times()[static_cast<std::size_t>(Stage::kSfm)].second.count, 2U);
  EXPECT_EQ(clock.stage_times()[static_cast<std::size_t>(Stage::kSfm)].first, "sfm");
}

TEST(StageClock, SurvivesDeepNesting) {
  BasicStageClock<HandClock> clock;
  clock.begin_frame();
  for (int depth = 0; depth < 6; ++depth) {
    clock.enter(Stage::kRefine);
    pass(1);
  }
  for (int depth = 0; depth < 6; ++depth) {
    clock.leave(Stage::kRefine);
  }
  clock.end_frame();
  EXPECT_DOUBLE_EQ(max_ms(clock, Stage::kRefine), 6.0);
  EXPECT_DOUBLE_EQ(clock.frame_time().max_ms, 6.0);
}

}  // namespace
}  // namespace kinetrace::app
