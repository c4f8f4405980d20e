#include "kinetrace/core/latest_value.hpp"

#include <atomic>
#include <thread>

#include <gtest/gtest.h>

namespace kinetrace {
namespace {

TEST(LatestValue, IsEmptyUntilSomethingIsHandedOver) {
  LatestValue<int> latest;
  EXPECT_EQ(latest.fetch(), nullptr);
  latest.slot() = 5;
  EXPECT_EQ(latest.fetch(), nullptr) << "not handed over yet";
  EXPECT_FALSE(latest.publish());
  const int* value = latest.fetch();
  ASSERT_NE(value, nullptr);
  EXPECT_EQ(*value, 5);
  EXPECT_EQ(latest.fetch(), nullptr) << "fetched once";
}

TEST(LatestValue, TheNewestWins) {
  LatestValue<int> latest;
  for (int i = 0; i < 5; ++i) {
    latest.slot() = i;
    EXPECT_EQ(latest.publish(), i > 0) << "supersedes what nobody fetched";
  }
  EXPECT_EQ(*latest.fetch(), 4);
  EXPECT_EQ(latest.fetch(), nullptr);
}

TEST(LatestValue, WhatIsBeingReadIsNotWritten) {
  LatestValue<int> latest;
  latest.slot() = 1;
  latest.publish();
  const int* reading = latest.fetch();
  for (int i = 2; i < 10; ++i) {
    latest.slot() = i;
    latest.publish();
    EXPECT_EQ(*reading, 1);
  }
  EXPECT_EQ(*latest.fetch(), 9);
}

TEST(LatestValue, ValuesAreWholeAndOnlyGrowNewer) {
  struct Value {
    long number = 0;
    long copies[64] = {};
  };
  LatestValue<Value> latest;
  std::atomic<bool> ends{false};
  constexpr long kValues = 100'000;
  std::thread producer([&] {
    for (long i = 1; i <= kValues; ++i) {
      Value& value = latest.slot();
      value.number = i;
      for (long& copy : value.copies) {
        copy = i;
      }
      latest.publish();
    }
    ends = true;
  });
  long newest = 0;
  int wrong = 0;
  for (bool is_last = false; !is_last;) {
    is_last = ends;  // Before the fetch, so that the last value is not missed.
    if (const Value* value = latest.fetch()) {
      wrong += value->number > newest ? 0 : 1;
      newest = value->number;
      for (const long copy : value->copies) {
        wrong += copy == newest ? 0 : 1;
      }
    }
  }
  producer.join();
  EXPECT_EQ(wrong, 0);
  EXPECT_EQ(newest, kValues);
}

}  // namespace
}  // namespace kinetrace
