#include "kinetrace/sfm/config.hpp"

#include <cmath>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace kinetrace::sfm {
namespace {

using ::testing::HasSubstr;

TEST(BodyConfig, DefaultsAreValid) {
  EXPECT_TRUE(BodyConfig{}.validate("background"));
}

TEST(BodyConfig, AcceptsItsLimits) {
  BodyConfig config;
  config.window_frames = 1;
  EXPECT_TRUE(config.validate("object"));
  config.window_frames = 32;
  EXPECT_TRUE(config.validate("object"));
}

TEST(BodyConfig, NamesTheKeyThatIsOutOfRange) {
  const auto message = [](auto&& change) {
    BodyConfig config;
    change(config);
    const Status status = config.validate("object");
    return status ? std::string("valid") : status.error().message;
  };
  EXPECT_THAT(message([](BodyConfig& c) { c.window_frames = 33; }), HasSubstr("object.window_frames"));
  EXPECT_THAT(message([](BodyConfig& c) { c.window_frames = 0; }), HasSubstr("[1, 32], got 0"));
  EXPECT_THAT(message([](BodyConfig& c) { c.max_points = 3; }), HasSubstr("object.max_points"));
  EXPECT_THAT(message([](BodyConfig& c) { c.max_features = 0; }), HasSubstr("object.max_features"));
  EXPECT_THAT(message([](BodyConfig& c) { c.measurement_sigma_px = std::nan(""); }),
              HasSubstr("object.measurement_sigma_px"));
  EXPECT_THAT(message([](BodyConfig& c) { c.min_inlier_ratio = 1.01; }), HasSubstr("object.min_inlier_ratio"));
  EXPECT_THAT(message([](BodyConfig& c) { c.turn_rate_radps = -0.1; }), HasSubstr("object.turn_rate_radps"));
  EXPECT_THAT(message([](BodyConfig& c) { c.reject_after_frames = 251; }), HasSubstr("object.reject_after_frames"));
}

}  // namespace
}  // namespace kinetrace::sfm
