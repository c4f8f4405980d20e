// Disparity change of a right camera whose pose the run learnt late, from points measured twice.
#include "measurement/disparity_change.hpp"

#include <cmath>
#include <limits>
#include <random>
#include <vector>

#include <gtest/gtest.h>

namespace kinetrace::batch {
namespace {

using recording::Observation;

const StereoGeometry kGeometry{.fx_px = 700.0,
                               .fy_px = 700.0,
                               .cx_px = 600.0,
                               .cy_px = 180.0,
                               .baseline_m = 0.5,
                               .width_px = 1200,
                               .height_px = 360};

struct Frame {
  std::vector<Observation> before;
  std::vector<Observation> now;
};

/// Points across the image whose disparity changes by `middle` + `right` * x + `down` * y, with noise of .07 px.
Frame measured_twice(std::size_t points, double middle, double right, double down) {
  std::mt19937 random(5);
  std::uniform_real_distribution<double> u_px(0.0, kGeometry.width_px);
  std::uniform_real_distribution<double> v_px(0.0, kGeometry.height_px);
  std::normal_distribution<double> noise_px(0.0, 0.07);
  Frame frame;
  for (std::size_t i = 0; i < points; ++i) {
    Observation seen;
    seen.u_left_px = static_cast<float>(u_px(random));
    seen.v_px = static_cast<float>(v_px(random));
    seen.u_right_px = seen.u_left_px - 20.F;
    frame.before.push_back(seen);
    const double change_px = middle + right * (double{seen.u_left_px} - kGeometry.cx_px) / kGeometry.fx_px +
                             down * (double{seen.v_px} - kGeometry.cy_px) / kGeometry.fy_px;
    seen.u_right_px -= static_cast<float>(change_px + noise_px(random));
    frame.now.push_back(seen);
  }
  return frame;
}

TEST(DisparityChange, IsFoundAmongWrongMatches) {
  Frame frame = measured_twice(200, 0.6, -0.2, 1.5);
  for (std::size_t i = 0; i < frame.now.size(); i += 10) {
    frame.now[i].u_right_px += 0.9F;
  }
  frame.now[3].u_right_px = std::numeric_limits<float>::quiet_NaN();
  const DisparityChange change = DisparityChange::between(kGeometry, frame.before, frame.now);
  EXPECT_FALSE(change.is_zero());
  EXPECT_NEAR(change.at(kGeometry, kGeometry.cx_px, kGeometry.cy_px), 0.6, 0.03);
  EXPECT_NEAR(change.at(kGeometry, 1000.0, 300.0), 0.6 - 0.2 * 400.0 / 700.0 + 1.5 * 120.0 / 700.0, 0.06);
}

TEST(DisparityChange, IsZeroWhereOnlyMatchingDiffers) {
  const Frame frame = measured_twice(200, 0.02, 0.01, -0.02);
  EXPECT_TRUE(DisparityChange::between(kGeometry, frame.before, frame.now).is_zero());
}

TEST(DisparityChange, IsNotMadeOfAFewPoints) {
  const Frame frame = measured_twice(20, 0.6, 0.0, 0.0);
  EXPECT_TRUE(DisparityChange::between(kGeometry, frame.before, frame.now).is_zero());
  EXPECT_TRUE(DisparityChange::between(kGeometry, {}, {}).is_zero());
}

}  // namespace
}  // namespace kinetrace::batch
