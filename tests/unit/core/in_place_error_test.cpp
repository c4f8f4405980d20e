#include "kinetrace/core/in_place_error.hpp"

#include <cstdint>
#include <limits>
#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace kinetrace {
namespace {

using ::testing::EndsWith;
using ::testing::StartsWith;

Error error_of(std::string_view subject, std::initializer_list<std::string_view> parts) {
  return InPlaceError(ErrorCode::kIo, subject, parts);
}

TEST(InPlaceErrors, AreErrorsOfTheSameWords) {
  const Error error = error_of("a.png", {"has ", NumberText(std::numeric_limits<std::int64_t>::min()), " of ",
                                         NumberText(std::numeric_limits<std::uint64_t>::max())});
  EXPECT_EQ(error.code, ErrorCode::kIo);
  EXPECT_EQ(error.message, "a.png: has -9223372036854775808 of 18446744073709551615");
}

TEST(InPlaceErrors, KeepAPathsEndAndTheReason) {
  const std::string message = error_of(std::string(4000, 'f') + "/a.png", {"is empty"}).message;
  EXPECT_EQ(message.size(), InPlaceText::kMaxBytes);
  EXPECT_THAT(message, StartsWith("...fff"));
  EXPECT_THAT(message, EndsWith("f/a.png: is empty"));
}

TEST(InPlaceErrors, HoldJustWhatFits) {
  for (const std::size_t size : {InPlaceText::kMaxBytes - 7, InPlaceText::kMaxBytes - 6, InPlaceText::kMaxBytes}) {
    const std::string message = error_of(std::string(size, 'f'), {"empty"}).message;
    EXPECT_EQ(message.size(), InPlaceText::kMaxBytes) << size;
    EXPECT_EQ(message.starts_with("..."), size + 7 > InPlaceText::kMaxBytes) << size;
    EXPECT_THAT(message, EndsWith("f: empty"));
  }
  EXPECT_THAT(error_of("a.png", {std::string(2000, 'x')}).message, StartsWith("...: xx"));
}

TEST(InPlaceErrors, BecomeResults) {
  const auto outcome = [](bool good) -> InPlaceResult<int> {
    if (good) {
      return 3;
    }
    return Unexpected(InPlaceError(ErrorCode::kNotFound, "a.png", {"no such file"}));
  };
  const Result<int> three = outcome(true);
  EXPECT_EQ(three.value(), 3);
  const Result<int> none = outcome(false);
  ASSERT_FALSE(none);
  EXPECT_EQ(none.error().message, "a.png: no such file");
  EXPECT_TRUE(Status(InPlaceStatus()));
  EXPECT_EQ(Status(InPlaceStatus(Unexpected(outcome(false).error()))).error().code, ErrorCode::kNotFound);
}

}  // namespace
}  // namespace kinetrace
