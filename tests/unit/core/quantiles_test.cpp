#include "kinetrace/core/quantiles.hpp"

#include <array>
#include <span>
#include <vector>

#include <gtest/gtest.h>

namespace kinetrace {
namespace {

TEST(Median, IsTheUpperOneOfTwo) {
  std::vector<double> odd{5.0, 1.0, 3.0};
  std::vector<double> even{4.0, 1.0, 3.0, 2.0};
  EXPECT_EQ(median(odd), 3.0);
  EXPECT_EQ(median(even), 3.0);
}

TEST(Median, OfAPartLeavesTheRest) {
  std::array<int, 5> values{9, 8, 7, 1, 2};
  EXPECT_EQ(median(std::span(values).first(3)), 8);
  EXPECT_EQ(values[3], 1);
}

TEST(Median, OfACopyLeavesTheOrder) {
  const std::vector<int> values{3, 1, 2};
  EXPECT_EQ(median(std::vector(values)), 2);
}

}  // namespace
}  // namespace kinetrace
