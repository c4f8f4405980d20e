#include <filesystem>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "kinetrace/hal/dataset.hpp"
#include "recording_for_test.hpp"

namespace kinetrace::hal {
namespace {

using ::testing::HasSubstr;

constexpr const char* kCamera =
    R"({"extrinsic": {"baseline": 0.21, "pitch": 0.038, "roll": 0.0, "yaw": -0.02, "x": 1.7, "y": 0.1, "z": 1.22},
        "intrinsic": {"fx": 40.5, "fy": 41.5, "u0": 24.25, "v0": 16.5}})";

class Cityscapes : public ::testing::Test {
 protected:
  void add_frames(const std::string& kind, const std::string& recording, int first, int count) {
    const std::string city = recording.substr(0, recording.find('_'));
    for (int i = first; i < first + count; ++i) {
      const std::string number = std::to_string(1'000'000 + i).substr(1);
      const std::string stem = "/val/" + city + "/" + recording + "_" + number;
      test::write_color_image(folder_.file("leftImg8bit" + kind + stem + "_leftImg8bit.png"), 5);
      test::write_color_image(folder_.file("rightImg8bit" + kind + stem + "_rightImg8bit.png"), 6);
    }
    const std::string annotated = std::to_string(1'000'000 + first + count - 1).substr(1);
    test::write_text(camera_file(recording, annotated), kCamera);
  }
  std::string camera_file(const std::string& recording, const std::string& number) {
    const std::string city = recording.substr(0, recording.find('_'));
    return folder_.file("camera/val/" + city + "/" + recording + "_" + number + "_camera.json");
  }
  Result<Dataset> open(const std::string& sequence) {
    return open_dataset({.layout = DatasetLayout::kCityscapes, .path = folder_.path(), .sequence = sequence});
  }
  void expect_error(const std::string& sequence, ErrorCode code, const std::string& what) {
    const auto dataset = open(sequence);
    ASSERT_FALSE(dataset) << "expected: " << what;
    EXPECT_EQ(dataset.error().code, code) << dataset.error().message;
    EXPECT_THAT(dataset.error().message, HasSubstr(what));
  }
  kinetrace::test::TempFolder folder_;
};

TEST_F(Cityscapes, OpensARecordingOfACity) {
  add_frames("_sequence", "bonn_000003", 10, 3);
  add_frames("_sequence", "bonn_000004", 0, 2);
  const auto dataset = open("bonn_000003");
  ASSERT_TRUE(dataset) << dataset.error().message;
  EXPECT_EQ(dataset->name, "bonn_000003");
  ASSERT_EQ(dataset->frames.size(), 3U);
  EXPECT_EQ(dataset->frames[0].name(), "bonn_000003_000010");
  EXPECT_EQ(dataset->frames[0].frame_index, 10);
  EXPECT_TRUE(dataset->frames[0].complete());
  EXPECT_NEAR(dataset->nominal_rate_hz, 17, 1e-6);
  const StereoGeometry& geometry = *dataset->calibration.rectified;
  EXPECT_EQ(geometry.fx_px, 40.5);
  EXPECT_EQ(geometry.fy_px, 41.5);
  EXPECT_EQ(geometry.cx_px, 24.25);
  EXPECT_EQ(geometry.cy_px, 16.5);
  EXPECT_EQ(geometry.baseline_m, 0.21);
}

TEST_F(Cityscapes, TakesACityWithOneRecording) {
  add_frames("", "bonn_000003", 10, 3);
  EXPECT_EQ(open("bonn")->frames.size(), 3U);
  EXPECT_EQ(open("")->frames.size(), 3U);
}

TEST_F(Cityscapes, ListsWhatCanBeChosen) {
  expect_error("", ErrorCode::kNotFound, "no Cityscapes images here");
  add_frames("", "bonn_000003", 10, 1);
  add_frames("", "bonn_000004", 10, 1);
  add_frames("", "ulm_000001", 0, 1);
  expect_error("", ErrorCode::kInvalidArgument, "several sequences; choose one with --sequence: bonn, ulm");
  expect_error("bonn", ErrorCode::kInvalidArgument,
               "several sequences; choose one with --sequence: bonn_000003, bonn_000004");
  expect_error("bonn_000005", ErrorCode::kInvalidArgument, "no sequence 'bonn_000005'");
  expect_error("jena", ErrorCode::kInvalidArgument, "no sequence 'jena'");
}

TEST_F(Cityscapes, ReportsCalibrationProblems) {
  add_frames("", "ulm_000001", 0, 1);
  const std::string path = camera_file("ulm_000001", "000000");
  test::write_text(path, "{\"extrinsic\": {");
  expect_error("ulm", ErrorCode::kBadCalibration, path + ": is no valid JSON");
  test::write_text(path, R"({"extrinsic": {"baseline": "x"}, "intrinsic": {"fx": 1, "fy": 1, "u0": 24, "v0": 16}})");
  expect_error("ulm", ErrorCode::kBadCalibration, path + ": 'extrinsic.baseline' is missing or no number");
  test::write_text(path, R"({"extrinsic": {"baseline": -0.2}, "intrinsic": {"fx": 1, "fy": 1, "u0": 24, "v0": 16}})");
  expect_error("ulm", ErrorCode::kBadCalibration, "left and right look swapped");
  std::filesystem::remove(path);
  expect_error("ulm", ErrorCode::kNotFound, "no calibration: looked for");
}

}  // namespace
}  // namespace kinetrace::hal
