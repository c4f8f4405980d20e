#include "link/log_sink.hpp"

#include <string>

#include <gtest/gtest.h>

namespace kinetrace::publishing {
namespace {

constexpr std::int64_t kMinute_ns = 60'000'000'000;

void add(LogSink& sink, const std::string& line) {
  sink.add(line.data(), line.size());
}

TEST(LogSink, ThereIsOne) {
  auto first = LogSink::create(10);
  ASSERT_TRUE(first);
  const auto second = LogSink::create(10);
  ASSERT_FALSE(second);
  EXPECT_EQ(second.error().code, ErrorCode::kIllegalState);
  first->reset();
  EXPECT_TRUE(LogSink::create(10));
}

TEST(LogSink, KeepsLinesInOrderWithoutTheirEnd) {
  auto sink = LogSink::create(10);
  ASSERT_TRUE(sink);
  add(**sink, "first\n");
  add(**sink, "second \n");
  EXPECT_EQ((*sink)->take(), "first");
  EXPECT_EQ((*sink)->take(), "second");
  EXPECT_EQ((*sink)->take(), std::nullopt);
  EXPECT_EQ((*sink)->lines(), 2U);
}

TEST(LogSink, ShowsNoMoreThanAllowedInAMinute) {
  auto sink = LogSink::create(2);
  ASSERT_TRUE(sink);
  (*sink)->tick(kMinute_ns);
  for (int i = 0; i < 5; ++i) {
    add(**sink, "line " + std::to_string(i));
  }
  EXPECT_EQ((*sink)->take(), "line 0");
  EXPECT_EQ((*sink)->take(), "line 1");
  EXPECT_EQ((*sink)->take(), std::nullopt);
  EXPECT_EQ((*sink)->suppressed(), 3U);
  (*sink)->tick(2 * kMinute_ns - 1);
  add(**sink, "too early");
  EXPECT_EQ((*sink)->take(), std::nullopt);
  (*sink)->tick(2 * kMinute_ns);
  add(**sink, "again");
  EXPECT_EQ((*sink)->take(), "again");
}

TEST(LogSink, HoldsALimitedNumberOfUnreadLines) {
  auto sink = LogSink::create(1000);
  ASSERT_TRUE(sink);
  for (std::size_t i = 0; i < LogSink::kKept + 1; ++i) {
    add(**sink, "line");
  }
  EXPECT_EQ((*sink)->suppressed(), 1U);
}

TEST(LogSink, CutsWhatIsTooLongAndKnowsTheLatestReason) {
  auto sink = LogSink::create(0);
  ASSERT_TRUE(sink);
  add(**sink, std::string(1000, 'x'));
  EXPECT_EQ((*sink)->take(), std::nullopt) << "none may be shown";
  EXPECT_EQ((*sink)->take_reason(), std::string(255, 'x'));
  EXPECT_EQ((*sink)->take_reason(), "");
  add(**sink, "");
  EXPECT_EQ((*sink)->take_reason(), "");
}

}  // namespace
}  // namespace kinetrace::publishing
