#include "kinetrace/trajectory/trajectory_config.hpp"

#include <cmath>
#include <limits>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace kinetrace::trajectory {
namespace {

std::string message(void (*change)(TrajectoryConfig&)) {
  TrajectoryConfig config;
  change(config);
  const Status status = config.validate();
  return status ? std::string() : status.error().message;
}

TEST(TrajectoryConfig, DefaultsAndLimitsAreValid) {
  EXPECT_EQ(message([](TrajectoryConfig&) {}), "");
  EXPECT_EQ(message([](TrajectoryConfig& c) { c.velocity_window_s = 0.01; }), "");
  EXPECT_EQ(message([](TrajectoryConfig& c) { c.velocity_window_s = 1.0; }), "");
}

TEST(TrajectoryConfig, NamesTheKeyThatIsOutOfRange) {
  EXPECT_EQ(message([](TrajectoryConfig& c) { c.velocity_window_s = 1.1; }),
            "trajectory.velocity_window_s must be in [0.01, 1], got 1.1");
  EXPECT_THAT(message([](TrajectoryConfig& c) { c.velocity_window_s = 0.0; }), testing::HasSubstr("got 0"));
  EXPECT_THAT(message([](TrajectoryConfig& c) { c.min_moving_speed_mps = -0.1; }),
              testing::HasSubstr("trajectory.min_moving_speed_mps"));
  EXPECT_THAT(message([](TrajectoryConfig& c) { c.moving_significance = std::nan(""); }),
              testing::HasSubstr("trajectory.moving_significance"));
  EXPECT_THAT(message([](TrajectoryConfig& c) { c.motion.acceleration_mps2 = 0.0; }),
              testing::HasSubstr("trajectory.acceleration_mps2"));
  EXPECT_THAT(message([](TrajectoryConfig& c) { c.motion.tilt_radps2 = -1.0; }),
              testing::HasSubstr("trajectory.tilt_radps2"));
  EXPECT_THAT(message([](TrajectoryConfig& c) { c.stereo_sigma_px = std::numeric_limits<double>::infinity(); }),
              testing::HasSubstr("trajectory.stereo_sigma_px"));
  EXPECT_THAT(message([](TrajectoryConfig& c) { c.surface_sigma_m = -1.0; }),
              testing::HasSubstr("trajectory.surface_sigma_m"));
}

}  // namespace
}  // namespace kinetrace::trajectory
