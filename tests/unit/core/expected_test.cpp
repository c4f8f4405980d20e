#include "kinetrace/core/expected.hpp"

#include <memory>
#include <string>
#include <variant>
#include <vector>

#include <gtest/gtest.h>

namespace kinetrace {
namespace {

using Number = Expected<int, std::string>;
using Success = Expected<void, std::string>;

TEST(Expected, HoldsAValueOrTheReasonWhyThereIsNone) {
  const Number value = 7;
  ASSERT_TRUE(value.has_value());
  EXPECT_EQ(*value, 7);
  const Number failure = Unexpected(std::string("none"));
  ASSERT_FALSE(failure);
  EXPECT_EQ(failure.error(), "none");
  EXPECT_THROW(static_cast<void>(failure.value()), std::bad_variant_access);
}

TEST(Expected, IsADefaultValueByDefault) {
  const Number number;
  ASSERT_TRUE(number);
  EXPECT_EQ(*number, 0);
  EXPECT_TRUE(Success().has_value());
}

TEST(Expected, FallsBackOnlyWhereThereIsNoValue) {
  EXPECT_EQ(Number(7).value_or(1), 7);
  EXPECT_EQ(Number(Unexpected(std::string("none"))).value_or(1), 1);
}

TEST(Expected, MovesWhatCannotBeCopied) {
  Expected<std::unique_ptr<int>, std::string> held = std::make_unique<int>(3);
  const std::unique_ptr<int> taken = *std::move(held);
  EXPECT_EQ(*taken, 3);
}

TEST(Expected, ConvertsAsItsValueConvertsAndKeepsTheReason) {
  const auto make = [](bool succeeds) -> Expected<const char*, std::string> {
    if (!succeeds) {
      return Unexpected(std::string("none"));
    }
    return "text";
  };
  const Expected<std::string, std::string> text = make(true);
  EXPECT_EQ(text.value(), "text");
  const Expected<std::string, std::string> failure = make(false);
  EXPECT_EQ(failure.error(), "none");
}

TEST(Expected, ChainsUntilTheFirstFailure) {
  int calls = 0;
  const auto half = [&calls](int n) -> Number {
    ++calls;
    if (n % 2 != 0) {
      return Unexpected(std::to_string(n) + " is odd");
    }
    return n / 2;
  };
  const Number result = Number(6).and_then(half).and_then(half).and_then(half);
  ASSERT_FALSE(result);
  EXPECT_EQ(result.error(), "3 is odd");
  EXPECT_EQ(calls, 2);
}

TEST(Expected, TransformsValuesAndLeavesReasonsAlone) {
  const auto text = [](int n) { return std::string(static_cast<std::size_t>(n), 'x'); };
  EXPECT_EQ(Number(3).transform(text).value(), "xxx");
  EXPECT_EQ(Number(Unexpected(std::string("none"))).transform(text).error(), "none");
}

TEST(Expected, OfNothingIsSuccessOrAReason) {
  Success status;
  EXPECT_TRUE(status);
  status = Unexpected(std::string("none"));
  ASSERT_FALSE(status);
  EXPECT_EQ(status.error(), "none");
}

}  // namespace
}  // namespace kinetrace
