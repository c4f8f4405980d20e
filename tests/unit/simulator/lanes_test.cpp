// Functions that kernels compute eight at a time, against the standard library.
#include <cmath>

#include <gtest/gtest.h>

// A separate kernel, for this test's instruction set.
#define KINETRACE_KERNEL_ISA kernel_of_test
#include "shading/pattern.hpp"
#include "util/lanes.hpp"

namespace kinetrace::simulator::kernel_of_test {
namespace {

TEST(Lanes, SinesAreThoseOfTheStandardLibrary) {
  for (float angle = -150.F; angle < 150.F; angle += 0.0137F) {
    ASSERT_NEAR(sin(Floats(angle)).v[3], std::sin(angle), 5e-6F) << angle;
  }
}

TEST(Lanes, AnglesAreThoseOfTheStandardLibrary) {
  for (float angle = -3.14F; angle < 3.14F; angle += 0.00071F) {
    const float x = 7.F * std::cos(angle);
    const float y = 7.F * std::sin(angle);
    ASSERT_NEAR(atan2(Floats(y), Floats(x)).v[5], std::atan2(y, x), 1e-6F) << angle;
  }
  EXPECT_EQ(atan2(Floats(0.F), Floats(0.F)).v[0], 0.F);
}

TEST(Lanes, FloorsBelowZeroAndAbove) {
  for (const float x : {-2.F, -1.75F, -0.25F, 0.F, 0.25F, 1.F, 1.75F}) {
    EXPECT_EQ(floor_of(Floats(x)).v[0], std::floor(x));
  }
}

TEST(Lanes, AnyTellsEachLane) {
  EXPECT_FALSE(any(Floats(0.F) > 0.F));
  for (int lane = 0; lane < kLanes; ++lane) {
    Floats values(0.F);
    values.v[lane] = 1.F;
    EXPECT_TRUE(any(values > 0.F)) << lane;
  }
}

TEST(Pattern, CellsHaveTheValueOfTheirHash) {
  for (int column = -3; column <= 3; ++column) {
    EXPECT_EQ(cell_value(static_cast<float>(column), -2.F, 17U).v[1], unit_float(hash_of(17U, column, -2)));
  }
}

TEST(Pattern, StripesCoverTheirShareOfAWidePixel) {
  EXPECT_FLOAT_EQ(stripes(0.05F, 1.F, 0.1F, 0.01F).v[0], 1.F);
  EXPECT_FLOAT_EQ(stripes(0.5F, 1.F, 0.1F, 0.01F).v[0], 0.F);
  EXPECT_NEAR(stripes(-3.3F, 1.F, 0.1F, 4.F).v[0], 0.1F, 1e-6F);
}

}  // namespace
}  // namespace kinetrace::simulator::kernel_of_test
