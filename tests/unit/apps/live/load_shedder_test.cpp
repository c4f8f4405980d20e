#include "live/load_shedder.hpp"

#include <gtest/gtest.h>

namespace kinetrace::app {
namespace {

constexpr double kDeadline_ms = 30.0;
constexpr double kLate_ms = 35.0;
constexpr double kInTime_ms = 25.0;
constexpr double kFast_ms = 10.0;

/// Frames until the level changes; at most `most`.
int frames_until_change(LoadShedder& shedder, double processing_ms, int most = 10'000) {
  for (int frames = 1; frames <= most; ++frames) {
    if (shedder.update(processing_ms)) {
      return frames;
    }
  }
  return most + 1;
}

TEST(LoadShedder, DoesEverythingWhileInTime) {
  LoadShedder shedder(kDeadline_ms, 8);
  EXPECT_EQ(frames_until_change(shedder, kInTime_ms, 500), 501);
  EXPECT_EQ(shedder.effort(), Effort{});
  EXPECT_EQ(shedder.health_reason(), std::nullopt);
}

TEST(LoadShedder, OneLateFrameInTwoIsTooMuchOneInThreeIsNot) {
  LoadShedder often(kDeadline_ms, 8);
  LoadShedder seldom(kDeadline_ms, 8);
  int changes = 0;
  for (int i = 0; i < 100; ++i) {
    often.update(i % 2 == 0 ? kLate_ms : kInTime_ms);
    changes += seldom.update(i % 3 == 0 ? kLate_ms : kInTime_ms) ? 1 : 0;
  }
  EXPECT_GT(often.level(), 0);
  EXPECT_EQ(changes, 0);
}

TEST(LoadShedder, ShedsInTheDeclaredOrderAndNeverBeyondTheLast) {
  LoadShedder shedder(kDeadline_ms, 8);
  Effort before = shedder.effort();
  HealthReason last = HealthReason::kCameraStalled;
  for (int level = 1; level < LoadShedder::kLevels; ++level) {
    EXPECT_EQ(frames_until_change(shedder, kLate_ms), static_cast<int>(LoadShedder::kMaxLateFrames));
    EXPECT_EQ(shedder.level(), level);
    const Effort now = shedder.effort();
    EXPECT_LE(now.refinement_iterations, before.refinement_iterations);
    EXPECT_LE(now.points, before.points);
    EXPECT_LE(now.objects, before.objects);
    EXPECT_NE(now, before);
    ASSERT_TRUE(shedder.health_reason());
    EXPECT_GE(*shedder.health_reason(), last);
    last = *shedder.health_reason();
    before = now;
  }
  EXPECT_EQ(last, HealthReason::kShedsObjects);
  EXPECT_EQ(before.objects, 2);
  EXPECT_EQ(frames_until_change(shedder, kLate_ms, 500), 501);
}

TEST(LoadShedder, AtLeastOneObjectIsFollowed) {
  LoadShedder shedder(kDeadline_ms, 1);
  for (int level = 1; level < LoadShedder::kLevels; ++level) {
    frames_until_change(shedder, kLate_ms);
  }
  EXPECT_EQ(shedder.effort().objects, 1);
}

TEST(LoadShedder, ReturnsLevelByLevelWhenThereIsTime) {
  LoadShedder shedder(kDeadline_ms, 8);
  frames_until_change(shedder, kLate_ms);
  frames_until_change(shedder, kLate_ms);
  EXPECT_EQ(frames_until_change(shedder, kInTime_ms, 500), 501) << "in time, but not with room for more";
  EXPECT_EQ(frames_until_change(shedder, kFast_ms), LoadShedder::kRecoveryFrames);
  EXPECT_EQ(shedder.level(), 1);
  EXPECT_EQ(frames_until_change(shedder, kFast_ms), LoadShedder::kRecoveryFrames);
  EXPECT_EQ(shedder.level(), 0);
}

TEST(LoadShedder, SingleSlowFramesDelayAReturnManyPreventIt) {
  const auto returns = [](int slow_every) {
    LoadShedder shedder(kDeadline_ms, 8);
    frames_until_change(shedder, kLate_ms);
    int frames = 0;
    while (shedder.level() > 0 && frames < 2000) {
      shedder.update(++frames % slow_every == 0 ? kInTime_ms : kFast_ms);
    }
    return frames;
  };
  EXPECT_EQ(returns(20), 115) << "five slow frames, each of which costs ten fast ones";
  EXPECT_EQ(returns(10), 2000);
}

TEST(LoadShedder, AReturnThatProvesWrongIsTriedLessAndLessOften) {
  LoadShedder shedder(kDeadline_ms, 8);
  frames_until_change(shedder, kLate_ms);
  int last = 0;
  for (const int times : {1, 2, 4, 8, 16, 16}) {
    last = frames_until_change(shedder, kFast_ms);
    EXPECT_EQ(last, times * LoadShedder::kRecoveryFrames);
    EXPECT_EQ(shedder.level(), 0);
    frames_until_change(shedder, kLate_ms);
    EXPECT_EQ(shedder.level(), 1);
  }
}

}  // namespace
}  // namespace kinetrace::app
