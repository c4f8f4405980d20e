#include "kinetrace/hal/timeline_guard.hpp"

#include <gtest/gtest.h>

namespace kinetrace::hal {
namespace {

constexpr std::int64_t kPeriod = 100;
constexpr std::int64_t kTolerance = 50;

TEST(TimelineGuard, LeavesTimesAloneThatFit) {
  TimelineGuard guard(kTolerance);
  EXPECT_EQ(guard.correct(-7, 12345).time_ns, -7) << "the first time has nothing to fit to";
  EXPECT_EQ(guard.correct(93, kPeriod).time_ns, 93);
  EXPECT_EQ(guard.correct(93 + 150, kPeriod).time_ns, 243);
  EXPECT_EQ(guard.correct(243 + 50, kPeriod).time_ns, 293);
  EXPECT_FALSE(guard.correct(293 + 5 * kPeriod, 5 * kPeriod).jumped) << "a gap that the evidence knows of";
}

TEST(TimelineGuard, ContinuesByTheEvidenceWhenTheClockJumps) {
  for (const std::int64_t jump : {std::int64_t{1'000'000}, std::int64_t{-1'000'000}, std::int64_t{51 + kPeriod}}) {
    TimelineGuard guard(kTolerance);
    static_cast<void>(guard.correct(0, 0));
    const TimelineGuard::Step jumped = guard.correct(kPeriod + jump, kPeriod);
    EXPECT_TRUE(jumped.jumped);
    EXPECT_EQ(jumped.time_ns, kPeriod);
    const TimelineGuard::Step after = guard.correct(2 * kPeriod + 3 + jump, kPeriod);
    EXPECT_FALSE(after.jumped);
    EXPECT_EQ(after.time_ns, 2 * kPeriod + 3) << "exact again, only shifted";
  }
}

TEST(TimelineGuard, ReturnsToTheClockWhenItIsRightAgain) {
  TimelineGuard guard(kTolerance);
  static_cast<void>(guard.correct(0, 0));
  // The evidence is off by 20 at the jump; a guard that only shifts would keep that error for ever.
  EXPECT_EQ(guard.correct(1'000'000, kPeriod + 20).time_ns, kPeriod + 20);
  const TimelineGuard::Step back = guard.correct(2 * kPeriod, kPeriod);
  EXPECT_TRUE(back.jumped);
  EXPECT_EQ(back.time_ns, 2 * kPeriod);
}

TEST(TimelineGuard, AcceptsWhateverLiesWithinTheEvidence) {
  constexpr std::int64_t kLong = 40 * kPeriod;
  TimelineGuard guard(kTolerance);
  static_cast<void>(guard.correct(0, 0));
  // The frame waited in the driver: the elapsed time is between zero and the whole delay.
  EXPECT_EQ(guard.correct(kPeriod, {.expected_ns = kLong, .shortest_ns = 0, .longest_ns = kLong}).time_ns, kPeriod);
  EXPECT_EQ(guard.correct(kLong, {.expected_ns = kPeriod, .shortest_ns = 0, .longest_ns = kLong}).time_ns, kLong);
  const TimelineGuard::Step jumped =
      guard.correct(3 * kLong, {.expected_ns = kPeriod, .shortest_ns = 0, .longest_ns = kLong});
  EXPECT_TRUE(jumped.jumped);
  EXPECT_EQ(jumped.time_ns, kLong + kPeriod);
}

TEST(TimelineGuard, WhereEveryFrameIsNewTimeMustAdvance) {
  TimelineGuard relaxed(kTolerance + kPeriod);
  TimelineGuard strict(kTolerance + kPeriod, true);
  for (TimelineGuard* guard : {&relaxed, &strict}) {
    static_cast<void>(guard->correct(1000, 0));
  }
  EXPECT_EQ(relaxed.correct(1000, kPeriod).time_ns, 1000);
  EXPECT_EQ(strict.correct(1000, kPeriod).time_ns, 1000 + kPeriod);
}

TEST(TimelineGuard, BeginsAnewAfterReset) {
  TimelineGuard guard(kTolerance);
  static_cast<void>(guard.correct(0, 0));
  static_cast<void>(guard.correct(5000, kPeriod));
  guard.reset();
  EXPECT_EQ(guard.correct(77, kPeriod).time_ns, 77);
}

}  // namespace
}  // namespace kinetrace::hal
