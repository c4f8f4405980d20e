#include <filesystem>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "kinetrace/hal/dataset.hpp"
#include "recording_for_test.hpp"

namespace kinetrace::hal {
namespace {

using ::testing::HasSubstr;

// Cameras look along the body's x axis; `y_m` is the view's place on the body's y axis (left positive).
std::string sensor_yaml(double y_m, const std::string& model = "radial-tangential",
                        const std::string& coefficients = "[-0.28, 0.07, 0.0002, 0.00002]") {
  return "%YAML:1.0\n#General sensor definitions.\nsensor_type: camera\nT_BS:\n  cols: 4\n  rows: 4\n"
         "  data: [0.0, 0.0, 1.0, 0.0,\n         -1.0, 0.0, 0.0, " +
         std::to_string(y_m) +
         ",\n         0.0, -1.0, 0.0, 0.0,\n         0.0, 0.0, 0.0, 1.0]\nrate_hz: 20\nresolution: [48, 32]\n"
         "camera_model: pinhole\nintrinsics: [40.0, 41.0, 24.0, 16.0] #fu, fv, cu, cv\ndistortion_model: " +
         model + "\ndistortion_coefficients: " + coefficients + "\n";
}

constexpr std::int64_t kStart_ns = 1403715273262142976;
constexpr std::int64_t kPeriod_ns = 50'000'000;

class Euroc : public ::testing::Test {
 protected:
  Euroc() {
    test::write_text(camera("cam0") + "/sensor.yaml", sensor_yaml(0.055));
    test::write_text(camera("cam1") + "/sensor.yaml", sensor_yaml(-0.055));
  }
  std::string camera(const std::string& name) { return (folder_.path() / "V1_01/mav0" / name).string(); }
  // Images at kStart_ns + offsets, with their data.csv.
  void add_images(const std::string& name, const std::vector<std::int64_t>& offsets_ns) {
    std::string csv = "#timestamp [ns],filename\r\n";
    for (const std::int64_t offset_ns : offsets_ns) {
      const std::string stem = std::to_string(kStart_ns + offset_ns);
      test::write_image(camera(name) + "/data/" + stem + ".png", 3);
      csv += stem + "," + stem + ".png\r\n";
    }
    test::write_text(camera(name) + "/data.csv", csv);
  }
  Result<Dataset> open(const std::string& below = "V1_01", const std::string& sequence = "") {
    return open_dataset({.layout = DatasetLayout::kEuroc, .path = folder_.path() / below, .sequence = sequence});
  }
  void expect_error(ErrorCode code, const std::string& what) {
    const auto dataset = open();
    ASSERT_FALSE(dataset) << "expected: " << what;
    EXPECT_EQ(dataset.error().code, code) << dataset.error().message;
    EXPECT_THAT(dataset.error().message, HasSubstr(what));
  }
  kinetrace::test::TempFolder folder_;
};

TEST_F(Euroc, ReadsCalibrationAndTimes) {
  add_images("cam0", {0, kPeriod_ns, 2 * kPeriod_ns});
  add_images("cam1", {0, kPeriod_ns, 2 * kPeriod_ns});
  const auto dataset = open();
  ASSERT_TRUE(dataset) << dataset.error().message;
  EXPECT_EQ(dataset->name, "V1_01");
  const RigCalibration& rig = dataset->calibration;
  EXPECT_TRUE(rig.T_right_left.translation.isApprox(Eigen::Vector3d(-0.11, 0, 0), 1e-9));
  EXPECT_TRUE(rig.T_right_left.rotation.isIdentity(1e-12));
  EXPECT_EQ(rig.left.fy_px, 41.0);
  EXPECT_EQ(rig.right.distortion[2], 0.0002);
  EXPECT_EQ(rig.left.lens, LensModel::kRadialTangential);
  EXPECT_NEAR(dataset->nominal_rate_hz, 20, 1e-9);
  EXPECT_EQ(dataset->frames[2].frame_index, 2);
  EXPECT_EQ(dataset->frames[2].timestamp_ns, kStart_ns + 2 * kPeriod_ns);
}

TEST_F(Euroc, IsFoundFromEveryLevel) {
  add_images("cam0", {0});
  add_images("cam1", {0});
  EXPECT_TRUE(open("V1_01/mav0"));
  EXPECT_TRUE(open("", "V1_01"));
  EXPECT_TRUE(open(""));
  EXPECT_EQ(open("V1_01/mav0")->name, "V1_01");
  EXPECT_THAT(open("", "V2").error().message, HasSubstr("no sequence 'V2'; choose one with --sequence: V1_01"));
}

TEST_F(Euroc, PairsTheNearestTimesWithinHalfAPeriod) {
  add_images("cam0", {0, kPeriod_ns, 2 * kPeriod_ns, 3 * kPeriod_ns});
  add_images("cam1", {100, kPeriod_ns + kPeriod_ns / 2 + 1, 2 * kPeriod_ns + 7, 3 * kPeriod_ns - kPeriod_ns / 2});
  const auto dataset = open();
  ASSERT_TRUE(dataset) << dataset.error().message;
  std::vector<std::string> pairs;
  for (std::size_t i = 0; i < dataset->frames.size(); ++i) {
    const FrameList::Frame frame = dataset->frames[i];
    if (frame.complete()) {
      pairs.push_back(std::string(frame.left_stem) + " " + std::string(frame.right_stem));
    }
  }
  const auto pair = [](std::int64_t left, std::int64_t right) {
    return std::to_string(kStart_ns + left) + " " + std::to_string(kStart_ns + right);
  };
  EXPECT_THAT(pairs, ::testing::ElementsAre(pair(0, 100), pair(2 * kPeriod_ns, 2 * kPeriod_ns + 7),
                                            pair(3 * kPeriod_ns, 3 * kPeriod_ns - kPeriod_ns / 2)));
}

TEST_F(Euroc, LostFramesLeaveGapsInTheNumbering) {
  add_images("cam0", {0, kPeriod_ns, 4 * kPeriod_ns, 5 * kPeriod_ns + 3000});
  add_images("cam1", {0, kPeriod_ns, 4 * kPeriod_ns, 5 * kPeriod_ns + 3000});
  const auto dataset = open();
  ASSERT_TRUE(dataset) << dataset.error().message;
  EXPECT_EQ(dataset->frames[2].frame_index, 4);
  EXPECT_EQ(dataset->frames[3].frame_index, 5);
}

TEST_F(Euroc, FilesOfTheListThatAreNotThereAreMissingSides) {
  add_images("cam0", {0, kPeriod_ns, 2 * kPeriod_ns});
  add_images("cam1", {0, kPeriod_ns, 2 * kPeriod_ns});
  std::filesystem::remove(camera("cam1") + "/data/" + std::to_string(kStart_ns + kPeriod_ns) + ".png");
  const auto dataset = open();
  ASSERT_TRUE(dataset) << dataset.error().message;
  EXPECT_EQ(dataset->frames.size(), 3U);
  EXPECT_EQ(dataset->frames.complete_count(), 2U);
}

TEST_F(Euroc, ReadsFisheyeSensors) {
  add_images("cam0", {0});
  add_images("cam1", {0});
  test::write_text(camera("cam0") + "/sensor.yaml", sensor_yaml(0.055, "equidistant"));
  test::write_text(camera("cam1") + "/sensor.yaml", sensor_yaml(-0.055, "equidistant"));
  const auto dataset = open();
  ASSERT_TRUE(dataset) << dataset.error().message;
  EXPECT_EQ(dataset->calibration.left.lens, LensModel::kEquidistant);
}

TEST_F(Euroc, ReportsDamagedFiles) {
  add_images("cam0", {0});
  add_images("cam1", {0});
  const std::string sensor = camera("cam0") + "/sensor.yaml";
  test::write_text(sensor, sensor_yaml(0.055, "polynomial"));
  expect_error(ErrorCode::kBadCalibration, sensor + ": 'distortion_model' is 'polynomial'");
  test::write_text(sensor, sensor_yaml(0.055, "radial-tangential", "[.nan, 0, 0, 0]"));
  expect_error(ErrorCode::kBadCalibration, sensor + ": 'distortion_coefficients' holds nan");
  test::write_text(sensor, sensor_yaml(0.055, "radial-tangential", "[0, 0, 0]"));
  expect_error(ErrorCode::kBadCalibration, "must be 4 to 5 numbers");
  test::write_text(sensor, sensor_yaml(-0.2));
  expect_error(ErrorCode::kBadCalibration, "left and right look swapped");
  std::filesystem::remove(sensor);
  expect_error(ErrorCode::kNotFound, "no calibration: looked for " + sensor);
  test::write_text(sensor, sensor_yaml(0.055));
  test::write_text(camera("cam0") + "/data.csv", "#h\nabc,def.png\n");
  expect_error(ErrorCode::kBadFormat, camera("cam0") + "/data.csv: 'abc,def.png' is no entry");
}

}  // namespace
}  // namespace kinetrace::hal
