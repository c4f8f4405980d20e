#include "kinetrace/core/crc32.hpp"

#include <span>
#include <string>
#include <string_view>

#include <gtest/gtest.h>

namespace kinetrace {
namespace {

TEST(Crc32, IsThatOfTheStandard) {
  const std::string_view check = "123456789";
  EXPECT_EQ(Crc32().update(std::as_bytes(std::span(check))).value(), 0xCBF43926U);
  // The same in pieces of every length.
  const std::string text = "the quick brown fox jumps over the lazy dog";
  const std::uint32_t whole = Crc32().update(std::as_bytes(std::span(text))).value();
  for (std::size_t cut = 0; cut <= text.size(); ++cut) {
    const auto bytes = std::as_bytes(std::span(text));
    EXPECT_EQ(Crc32().update(bytes.first(cut)).update(bytes.subspan(cut)).value(), whole) << cut;
  }
  EXPECT_EQ(Crc32().value(), 0U);
}

}  // namespace
}  // namespace kinetrace
