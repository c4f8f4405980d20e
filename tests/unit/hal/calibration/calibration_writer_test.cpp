#include <array>
#include <fstream>
#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <opencv2/core/persistence.hpp>

#include "kinetrace/hal/rectifier.hpp"
#include "rig_for_test.hpp"
#include "temp_folder.hpp"

namespace kinetrace::hal {
namespace {

using ::testing::HasSubstr;
using ::testing::StartsWith;

void expect_equal(const CameraModel& read, const CameraModel& written) {
  EXPECT_EQ(read.lens, written.lens);
  EXPECT_EQ(read.width_px, written.width_px);
  EXPECT_EQ(read.height_px, written.height_px);
  EXPECT_EQ(read.fx_px, written.fx_px);
  EXPECT_EQ(read.fy_px, written.fy_px);
  EXPECT_EQ(read.cx_px, written.cx_px);
  EXPECT_EQ(read.cy_px, written.cy_px);
  EXPECT_EQ(read.distortion, written.distortion);
}

RigCalibration written_and_read(const RigCalibration& rig, CalibrationFormat format) {
  const kinetrace::test::TempFolder folder;
  const std::array<std::string, 2> remarks{"one", "two\nlines: [are, no, YAML"};
  const std::string path = folder.file("rig.yaml");
  const Status written = write_rig_calibration(rig, path, format, remarks);
  EXPECT_TRUE(written) << written.error().message;
  const auto read = read_rig_calibration(path, rig.raw_width_px(), rig.raw_height_px());
  EXPECT_TRUE(read) << read.error().message;
  return read.value_or(RigCalibration{});
}

void expect_same_after_reading(const RigCalibration& rig, CalibrationFormat format) {
  const RigCalibration read = written_and_read(rig, format);
  expect_equal(read.left, rig.left);
  expect_equal(read.right, rig.right);
  EXPECT_TRUE(read.T_right_left.rotation.isApprox(rig.T_right_left.rotation, 1e-15));
  EXPECT_EQ(read.T_right_left.translation, rig.T_right_left.translation);
  EXPECT_FALSE(read.given || read.rectified);
}

TEST(CalibrationWriter, WritesWhatIsReadBackToTheSameNumbers) {
  for (const CalibrationFormat format : {CalibrationFormat::kOpencv, CalibrationFormat::kKalibr}) {
    expect_same_after_reading(test::radial_rig(), format);
    expect_same_after_reading(test::fisheye_rig(), format);
  }
  RigCalibration rational = test::radial_rig();
  rational.left.distortion = {-0.3, 0.1, 1e-5, -2e-5, 0.02, 0.01, -0.003, 1e-4};
  expect_same_after_reading(rational, CalibrationFormat::kOpencv);
}

TEST(CalibrationWriter, RefusesWhatAFormatCannotSay) {
  RigCalibration rig = test::radial_rig();
  rig.right.distortion[4] = 0.01;
  const auto kalibr = rig_calibration_text(rig, CalibrationFormat::kKalibr);
  ASSERT_FALSE(kalibr);
  EXPECT_EQ(kalibr.error().code, ErrorCode::kUnsupported);
  EXPECT_THAT(kalibr.error().message, HasSubstr("write an OpenCV file"));
  EXPECT_TRUE(rig_calibration_text(rig, CalibrationFormat::kOpencv));
  rig = test::fisheye_rig();
  rig.right.lens = LensModel::kRadialTangential;
  EXPECT_TRUE(rig_calibration_text(rig, CalibrationFormat::kKalibr));
  const auto opencv = rig_calibration_text(rig, CalibrationFormat::kOpencv);
  ASSERT_FALSE(opencv);
  EXPECT_EQ(opencv.error().code, ErrorCode::kUnsupported);
  rig = test::radial_rig();
  rig.left.fx_px = 0.0;
  const auto invalid = rig_calibration_text(rig, CalibrationFormat::kOpencv);
  ASSERT_FALSE(invalid);
  EXPECT_EQ(invalid.error().code, ErrorCode::kBadCalibration);
}

TEST(CalibrationWriter, BringsEveryFormOfARigIntoOne) {
  const RigCalibration given = test::given_rig();
  const RigCalibration raw = to_raw_rig(given);
  EXPECT_FALSE(raw.given);
  EXPECT_TRUE(raw.T_right_left.rotation.isApprox(given.T_right_left.rotation, 1e-12));
  EXPECT_TRUE(raw.T_right_left.translation.isApprox(given.T_right_left.translation, 1e-12));
  RigCalibration rectified = test::rectified_rig();
  const RigCalibration read = written_and_read(rectified, CalibrationFormat::kOpencv);
  const auto geometry = Rectifier::rectified_geometry(read, {});
  ASSERT_TRUE(geometry);
  EXPECT_NEAR(geometry->baseline_m, 0.5, 1e-12);
  EXPECT_NEAR(geometry->fx_px, 40.0, 1e-6);
}

TEST(CalibrationWriter, WritesWhatOpenCvReadsItself) {
  const auto text = rig_calibration_text(test::radial_rig(), CalibrationFormat::kOpencv, {});
  ASSERT_TRUE(text);
  EXPECT_THAT(*text, StartsWith("%YAML:1.0\n---\n"));
  const cv::FileStorage file(*text, cv::FileStorage::READ | cv::FileStorage::MEMORY);
  cv::Mat K;
  cv::Mat T;
  file["K2"] >> K;
  file["T"] >> T;
  ASSERT_EQ(K.size(), cv::Size(3, 3));
  ASSERT_EQ(T.size(), cv::Size(1, 3));
  EXPECT_EQ(K.at<double>(0, 0), test::radial_rig().right.fx_px);
  EXPECT_EQ(T.at<double>(2), test::radial_rig().T_right_left.translation.z());
}

TEST(CalibrationWriter, ReplacesACalibrationOfTheSameFormatOnly) {
  const kinetrace::test::TempFolder folder;
  const std::string path = folder.file("rig.yaml");
  const auto place = [&path](CalibrationFormat format) { return check_calibration_place(path, format); };
  EXPECT_TRUE(place(CalibrationFormat::kOpencv)) << "there is none";
  ASSERT_TRUE(write_rig_calibration(test::radial_rig(), path, CalibrationFormat::kOpencv));
  EXPECT_TRUE(place(CalibrationFormat::kOpencv));
  EXPECT_THAT(place(CalibrationFormat::kKalibr).error().message, HasSubstr("is no camchain of Kalibr"));
  ASSERT_TRUE(write_rig_calibration(test::radial_rig(), path, CalibrationFormat::kKalibr));
  EXPECT_TRUE(place(CalibrationFormat::kKalibr));
  const Status refused = place(CalibrationFormat::kOpencv);
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().code, ErrorCode::kOccupied);
  EXPECT_THAT(refused.error().message, HasSubstr(path + ": is there already, and is no calibration in OpenCV's YAML"));
  for (const char* other :
       {"notes: mine\n", "{", "<?xml version=\"1.0\"?>\n<opencv_storage><K1>1</K1></opencv_storage>\n"}) {
    std::ofstream(path) << other;
    EXPECT_FALSE(place(CalibrationFormat::kOpencv)) << other;
  }
  EXPECT_EQ(check_calibration_place(folder.path() / "no" / "rig.yaml", CalibrationFormat::kOpencv).error().code,
            ErrorCode::kIo);
}

}  // namespace
}  // namespace kinetrace::hal
