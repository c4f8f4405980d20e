#include "formats/calibration_text.hpp"

#include <gtest/gtest.h>

#include "rig_for_test.hpp"

namespace kinetrace::hal::test {
namespace {

TEST(CalibrationText, IsReadBackToTheSameNumbers) {
  for (const RigCalibration& rig : {radial_rig(), fisheye_rig(), given_rig(), rectified_rig()}) {
    const RigCalibration back = parse_calibration_text(calibration_text(rig), "file").value();
    EXPECT_EQ(calibration_text(back), calibration_text(rig));
    EXPECT_EQ(back.source, "file");
    EXPECT_EQ(back.given.has_value(), rig.given.has_value());
    EXPECT_EQ(back.raw_width_px(), rig.raw_width_px());
    EXPECT_EQ(back.left.distortion, rig.left.distortion);
  }
  EXPECT_EQ(parse_calibration_text("", "file").error().code, ErrorCode::kBadCalibration);
  EXPECT_EQ(parse_calibration_text("left: 1 2\nright: x\n", "file").error().code, ErrorCode::kBadCalibration);
}

}  // namespace
}  // namespace kinetrace::hal::test
