#include "kinetrace/hal/frame_list.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace kinetrace::hal {
namespace {

FrameList two_folders() {
  return {{"/data/left", ".png"}, {"/data/right_view", "_right.png"}};
}

TEST(FrameList, IsEmptyAtFirst) {
  const FrameList frames = two_folders();
  EXPECT_TRUE(frames.empty());
  EXPECT_EQ(frames.complete_count(), 0U);
  EXPECT_EQ(frames.median_period_ns(7), 7);
}

TEST(FrameList, GivesBackWhatWasAdded) {
  FrameList frames = two_folders();
  ASSERT_TRUE(frames.add({3, 100, "003", "003"}));
  ASSERT_TRUE(frames.add({4, 200, "004", ""}));
  ASSERT_TRUE(frames.add({5, 300, "", "5"}));
  ASSERT_TRUE(frames.add({6, 400, "6", "006"}));
  ASSERT_EQ(frames.size(), 4U);
  EXPECT_EQ(frames[0].frame_index, 3);
  EXPECT_EQ(frames[0].timestamp_ns, 100);
  EXPECT_EQ(frames[0].left_stem, "003");
  EXPECT_EQ(frames[0].right_stem, "003");
  EXPECT_TRUE(frames[0].complete());
  EXPECT_FALSE(frames[1].complete());
  EXPECT_EQ(frames[1].name(), "004");
  EXPECT_FALSE(frames[2].complete());
  EXPECT_EQ(frames[2].name(), "5");
  EXPECT_EQ(frames[3].left_stem, "6");
  EXPECT_EQ(frames[3].right_stem, "006");
  EXPECT_EQ(frames.complete_count(), 2U);
}

TEST(FrameList, RefusesWhatDoesNotIncrease) {
  FrameList frames = two_folders();
  ASSERT_TRUE(frames.add({3, 100, "a", "a"}));
  const Status same_index = frames.add({3, 200, "b", "b"});
  ASSERT_FALSE(same_index);
  EXPECT_EQ(same_index.error().code, ErrorCode::kBadFormat);
  const Status same_time = frames.add({4, 100, "b", "b"});
  ASSERT_FALSE(same_time);
  EXPECT_THAT(same_time.error().message, ::testing::HasSubstr("/data/left"));
  EXPECT_EQ(frames.size(), 1U);
}

TEST(FrameList, RefusesNumbersAndTimesThatNothingElseHolds) {
  const auto refuses = [](std::int64_t index, std::int64_t time_ns) {
    FrameList frames({"/data/left", ".png"}, {"/data/right", ".png"}, "/data/times.txt");
    const Status added = frames.add({index, time_ns, "a", "a"});
    EXPECT_TRUE(added || added.error().message.starts_with("/data/times.txt: frame a has the number"));
    return !added;
  };
  EXPECT_FALSE(refuses(FrameList::kMaxFrameIndex, FrameList::kMaxTime_ns));
  EXPECT_FALSE(refuses(0, FrameList::kMinTime_ns));
  EXPECT_TRUE(refuses(-1, 0));
  EXPECT_TRUE(refuses(FrameList::kMaxFrameIndex + 1, 0));
  EXPECT_TRUE(refuses(0, FrameList::kMaxTime_ns + 1));
  EXPECT_TRUE(refuses(0, FrameList::kMinTime_ns - 1));
}

TEST(FrameList, PeriodIsPerFrameNumberAndRobust) {
  FrameList frames = two_folders();
  ASSERT_TRUE(frames.add({0, 0, "0", "0"}));
  ASSERT_TRUE(frames.add({1, 100, "1", "1"}));
  ASSERT_TRUE(frames.add({4, 400, "4", "4"}));
  ASSERT_TRUE(frames.add({5, 9000, "5", "5"}));
  EXPECT_EQ(frames.median_period_ns(7), 100);
}

TEST(FrameList, KnowsItsLongestPath) {
  FrameList frames = two_folders();
  ASSERT_TRUE(frames.add({0, 0, "12345", "12345"}));
  EXPECT_EQ(frames.longest_path(), std::string("/data/right_view/12345_right.png").size());
}

}  // namespace
}  // namespace kinetrace::hal
