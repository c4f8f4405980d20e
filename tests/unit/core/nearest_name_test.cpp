#include "kinetrace/core/nearest_name.hpp"

#include <array>

#include <gtest/gtest.h>

namespace kinetrace {
namespace {

constexpr std::array<std::string_view, 5> kNames{"run", "record", "reference", "--segmentation", "raspberry-pi-5"};

TEST(NearestName, IsOneEditAway) {
  EXPECT_EQ(nearest_name("rn", kNames), "run");
  EXPECT_EQ(nearest_name("runn", kNames), "run");
  EXPECT_EQ(nearest_name("ran", kNames), "run");
  EXPECT_EQ(nearest_name("rnu", kNames), "run");
  EXPECT_EQ(nearest_name("--segmantation", kNames), "--segmentation");
  EXPECT_EQ(nearest_name("run", kNames), "run");
}

TEST(NearestName, LongWordsMayHaveMoreMistakes) {
  EXPECT_EQ(nearest_name("--sgmantaton", kNames), "--segmentation");
  EXPECT_EQ(nearest_name("raspbery-pi5", kNames), "raspberry-pi-5");
}

TEST(NearestName, OfNamesThatAreNearTheNearestIsTaken) {
  EXPECT_EQ(nearest_name("recrod", kNames), "record");
  EXPECT_EQ(nearest_name("refernce", kNames), "reference");
}

TEST(NearestName, WhatIsFarFromAllIsNone) {
  EXPECT_EQ(nearest_name("fly", kNames), std::nullopt);
  EXPECT_EQ(nearest_name("monitor", kNames), std::nullopt);
  EXPECT_EQ(nearest_name("", kNames), std::nullopt);
  EXPECT_EQ(nearest_name("x", kNames), std::nullopt);
  EXPECT_EQ(nearest_name("run", {}), std::nullopt);
}

TEST(NearestName, EndsAMessage) {
  EXPECT_EQ(did_you_mean("rnu", kNames), "; did you mean run?");
  EXPECT_EQ(did_you_mean("fly", kNames), "");
}

}  // namespace
}  // namespace kinetrace
