#include "synchronization/missed_frames.hpp"

#include <gtest/gtest.h>

namespace kinetrace::hal {
namespace {

TEST(MissedFrames, CountsNothingBeforeTheFirstPair) {
  MissedFrames missed;
  missed.see(View::kLeft, 3);
  missed.see(View::kLeft, 900);
  EXPECT_EQ(missed.deliver(1000, 7), 0U);
  EXPECT_EQ(missed.deliver(1001, 8), 0U);
}

TEST(MissedFrames, CountsWhatNeitherCameraSaw) {
  MissedFrames missed;
  static_cast<void>(missed.deliver(10, 500));
  missed.see(View::kLeft, 11);
  missed.see(View::kRight, 502);
  missed.see(View::kRight, 504);
  EXPECT_EQ(missed.deliver(15, 505), 1U) << "13 and 503 are the same frame";
  EXPECT_EQ(missed.deliver(16, 506), 0U);
  EXPECT_EQ(missed.deliver(20, 510), 3U);
}

TEST(MissedFrames, KnowsImagesThatCameBeforeThePairWasDelivered) {
  MissedFrames missed;
  static_cast<void>(missed.deliver(0, 0));
  missed.see(View::kLeft, 2);  // Its partner never arrives.
  EXPECT_EQ(missed.deliver(1, 1), 0U);
  EXPECT_EQ(missed.deliver(3, 3), 0U);
}

TEST(MissedFrames, AChangeOfPartnersIsNoLoss) {
  MissedFrames missed;
  static_cast<void>(missed.deliver(0, 0));
  missed.see(View::kRight, 1);
  EXPECT_EQ(missed.deliver(1, 2), 0U);
  EXPECT_EQ(missed.deliver(2, 3), 0U);
}

TEST(MissedFrames, ACameraMayBeSilentForLong) {
  MissedFrames missed;
  static_cast<void>(missed.deliver(0, 0));
  std::uint64_t lost = 0;
  for (std::int64_t number = 1; number < 5000; ++number) {
    if (number % 10 == 0) {
      ++lost;
    } else {
      missed.see(View::kRight, number);
    }
  }
  EXPECT_EQ(missed.deliver(5000, 5000), lost);
}

TEST(MissedFrames, BothMayBeSilentForLong) {
  MissedFrames missed;
  static_cast<void>(missed.deliver(0, 0));
  missed.see(View::kLeft, 1);
  missed.see(View::kLeft, 2000);
  EXPECT_EQ(missed.deliver(3000, 3000), 2997U);
}

TEST(MissedFrames, ARestartIsNoLoss) {
  MissedFrames missed;
  static_cast<void>(missed.deliver(0, 0));
  missed.see(View::kLeft, 7);
  missed.restart();
  EXPECT_EQ(missed.deliver(100, 100), 0U);
  EXPECT_EQ(missed.deliver(102, 102), 1U);
}

}  // namespace
}  // namespace kinetrace::hal
