#include "kinetrace/publishing/event_queue.hpp"

#include <thread>

#include <gtest/gtest.h>

namespace kinetrace::publishing {
namespace {

TEST(EventQueue, RefusesOneMoreThanItHolds) {
  Arena arena(4096);
  EventQueue<int> queue(arena, 3);
  int out = 0;
  EXPECT_FALSE(queue.pop(out));
  for (int i = 0; i < 3; ++i) {
    EXPECT_TRUE(queue.push(i));
  }
  EXPECT_FALSE(queue.push(3));
  ASSERT_TRUE(queue.pop(out));
  EXPECT_EQ(out, 0);
  EXPECT_TRUE(queue.push(4)) << "room again";
  for (const int expected : {1, 2, 4}) {
    ASSERT_TRUE(queue.pop(out));
    EXPECT_EQ(out, expected);
  }
  EXPECT_FALSE(queue.pop(out));
}

TEST(EventQueue, KeepsOrderAndContentBetweenThreads) {
  struct Event {
    int number;
    int square;
  };
  constexpr int kEvents = 200'000;
  Arena arena(4096);
  EventQueue<Event> queue(arena, 16);
  std::thread producer([&queue] {
    for (int i = 0; i < kEvents;) {
      i += queue.push({i, i % 1000 * (i % 1000)}) ? 1 : 0;
    }
  });
  int wrong = 0;
  Event event{};
  for (int i = 0; i < kEvents;) {
    if (queue.pop(event)) {
      wrong += event.number == i && event.square == i % 1000 * (i % 1000) ? 0 : 1;
      ++i;
    }
  }
  producer.join();
  EXPECT_EQ(wrong, 0);
}

}  // namespace
}  // namespace kinetrace::publishing
