#include "kinetrace/core/fixed_vector.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace kinetrace {
namespace {

using ::testing::ElementsAre;

TEST(FixedVector, DefaultHasNoCapacity) {
  FixedVector<int> v;
  EXPECT_TRUE(v.empty());
  EXPECT_TRUE(v.full());
  EXPECT_FALSE(v.push_back(1));
}

TEST(FixedVector, TakesCapacityElementsAndRefusesOneMore) {
  Arena arena(1024);
  FixedVector<int> v(arena, 3);
  EXPECT_TRUE(v.push_back(1));
  EXPECT_TRUE(v.push_back(2));
  EXPECT_FALSE(v.full());
  EXPECT_TRUE(v.push_back(3));
  EXPECT_TRUE(v.full());
  EXPECT_FALSE(v.push_back(4));
  EXPECT_THAT(v.span(), ElementsAre(1, 2, 3));
}

TEST(FixedVector, SwapRemoveMovesTheLastIntoTheGap) {
  Arena arena(1024);
  FixedVector<int> v(arena, 4);
  for (const int i : {1, 2, 3, 4}) {
    ASSERT_TRUE(v.push_back(i));
  }
  v.swap_remove(1);
  EXPECT_THAT(v.span(), ElementsAre(1, 4, 3));
  v.swap_remove(2);
  EXPECT_THAT(v.span(), ElementsAre(1, 4));
  v.swap_remove(0);
  v.swap_remove(0);
  EXPECT_TRUE(v.empty());
}

TEST(FixedVector, ResizeInitialisesWhatItAddsAndClampsToTheCapacity) {
  Arena arena(1024);
  FixedVector<int> v(arena, 4);
  ASSERT_TRUE(v.push_back(7));
  ASSERT_TRUE(v.push_back(8));
  v.resize(1);
  EXPECT_THAT(v.span(), ElementsAre(7));
  v.resize(3);
  EXPECT_THAT(v.span(), ElementsAre(7, 0, 0));
  v.resize(100);
  EXPECT_EQ(v.size(), 4U);
}

TEST(FixedVector, PopsAndClears) {
  Arena arena(1024);
  FixedVector<int> v(arena, 2);
  ASSERT_TRUE(v.push_back(7));
  ASSERT_TRUE(v.push_back(8));
  v.pop_back();
  EXPECT_EQ(v.back(), 7);
  v.clear();
  EXPECT_TRUE(v.empty());
  EXPECT_EQ(v.capacity(), 2U);
}

}  // namespace
}  // namespace kinetrace
