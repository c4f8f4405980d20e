#include "kinetrace/rig/config.hpp"

#include <limits>

#include <gtest/gtest.h>

namespace kinetrace::rig {
namespace {

TEST(RefineConfig, NamesTheKeyThatIsOutOfRange) {
  RefineConfig config;
  EXPECT_TRUE(config.validate());
  config.max_points = 39;
  ASSERT_FALSE(config.validate());
  EXPECT_NE(config.validate().error().message.find("calibration.max_points"), std::string::npos);
  config = {};
  config.bias_px = std::numeric_limits<double>::quiet_NaN();
  ASSERT_FALSE(config.validate());
  EXPECT_NE(config.validate().error().message.find("calibration.bias_px"), std::string::npos);
}

TEST(RefineConfig, ModesHaveNamesThatAreReadBack) {
  for (const RefineMode mode : {RefineMode::kOff, RefineMode::kCheck, RefineMode::kOn}) {
    RefineMode read = RefineMode::kOff;
    EXPECT_TRUE(from_string(to_string(mode), read));
    EXPECT_EQ(read, mode);
  }
  RefineMode mode = RefineMode::kCheck;
  EXPECT_FALSE(from_string("of", mode));
  EXPECT_EQ(mode, RefineMode::kCheck);
}

}  // namespace
}  // namespace kinetrace::rig
