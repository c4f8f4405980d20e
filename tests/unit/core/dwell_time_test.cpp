#include "kinetrace/core/dwell_time.hpp"

#include <random>

#include <gtest/gtest.h>

namespace kinetrace {
namespace {

int frames_until(std::int64_t limit_ns, std::int64_t interval_ns) {
  DwellTime dwell;
  int frames = 0;
  do {
    dwell.add_frame(interval_ns);
    ++frames;
  } while (!dwell.exceeds(limit_ns));
  return frames;
}

TEST(DwellTime, ALimitOfWholeIntervalsIsExceededByTheFrameAfterThem) {
  for (const int limit : {0, 1, 2, 5, 10, 85}) {
    EXPECT_EQ(frames_until(limit * kUsualInterval_ns, kUsualInterval_ns), limit + 1);
  }
  EXPECT_EQ(to_ns(0.1), kUsualInterval_ns);
}

TEST(DwellTime, IsTheSameInSecondsAtEveryRate) {
  for (const int rate_hz : {5, 10, 20, 30, 60, 120}) {
    const std::int64_t interval_ns = 1'000'000'000 / rate_hz;
    const double seconds = 1e-9 * static_cast<double>(interval_ns * frames_until(to_ns(1.0), interval_ns));
    EXPECT_NEAR(seconds, 1.0 + 1.0 / rate_hz, 1e-3) << rate_hz << " Hz";
  }
}

TEST(DwellTime, JitterOfTimeStampsDoesNotDecide) {
  std::mt19937 random(7);
  std::uniform_int_distribution<std::int64_t> jitter_ns(-20'000'000, 20'000'000);
  for (int run = 0; run < 1000; ++run) {
    DwellTime dwell;
    std::int64_t before_ns = jitter_ns(random);
    for (int frame = 1; frame <= 11; ++frame) {
      const std::int64_t now_ns = frame * kUsualInterval_ns + jitter_ns(random);
      dwell.add_frame(now_ns - before_ns);
      before_ns = now_ns;
      ASSERT_EQ(dwell.exceeds(10 * kUsualInterval_ns), frame > 10);
    }
  }
}

TEST(DwellTime, BeginsAnewAfterAReset) {
  DwellTime dwell;
  dwell.add_frame(kUsualInterval_ns);
  dwell.add_frame(kUsualInterval_ns);
  dwell.reset();
  EXPECT_EQ(dwell.ns(), 0);
  EXPECT_FALSE(dwell.exceeds(0));
  dwell.add_frame(kUsualInterval_ns);
  EXPECT_TRUE(dwell.exceeds(0));
  EXPECT_FALSE(dwell.exceeds(kUsualInterval_ns));
}

}  // namespace
}  // namespace kinetrace
