#include <filesystem>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "kinetrace/hal/dataset.hpp"
#include "kinetrace/hal/rectifier.hpp"
#include "recording_for_test.hpp"

namespace kinetrace::hal {
namespace {

using ::testing::Contains;
using ::testing::HasSubstr;

std::string matrix(const std::string& key, int rows, int cols, const std::string& data) {
  return key + ": !!opencv-matrix\n   rows: " + std::to_string(rows) + "\n   cols: " + std::to_string(cols) +
         "\n   dt: d\n   data: [ " + data + " ]\n";
}

std::string opencv_intrinsics(const std::string& K, const std::string& D) {
  return matrix(K + "1", 3, 3, "40., 0., 24., 0., 41., 16., 0., 0., 1.") +
         matrix(D + "1", 1, 5, "-0.1, 0.01, 0.001, 0.002, 0.003") +
         matrix(K + "2", 3, 3, "42., 0., 25., 0., 43., 17., 0., 0., 1.") +
         matrix(D + "2", 1, 5, "-0.11, 0.02, 0., 0., 0.");
}
std::string opencv_extrinsics(const std::string& T) {
  return matrix("R", 3, 3, "1., 0., 0., 0., 1., 0., 0., 0., 1.") + matrix("T", 3, 1, T);
}

std::string ros_camera(const std::string& offset, const std::string& model = "plumb_bob") {
  return "image_width: 48\nimage_height: 32\ncamera_name: narrow_stereo\ncamera_matrix:\n  rows: 3\n  cols: 3\n"
         "  data: [40, 0, 24, 0, 40, 16, 0, 0, 1]\ndistortion_model: " +
         model +
         "\ndistortion_coefficients:\n  rows: 1\n  cols: 5\n  data: [-0.1, 0.01, 0, 0, 0]\nrectification_matrix:\n"
         "  rows: 3\n  cols: 3\n  data: [1, 0, 0, 0, 1, 0, 0, 0, 1]\nprojection_matrix:\n  rows: 3\n  cols: 4\n"
         "  data: [38, 0, 23, " +
         offset + ", 0, 38, 15, 0, 0, 0, 1, 0]\n";
}

std::string kalibr(const std::string& model, const std::string& x) {
  const std::string camera =
      "  camera_model: pinhole\n  distortion_coeffs: [0.01, 0.02, 0.003, 0.004]\n"
      "  distortion_model: " +
      model +
      "\n  intrinsics: [40.0, 41.0, 24.0, 16.0]\n"
      "  resolution: [48, 32]\n";
  return "cam0:\n" + camera + "cam1:\n  T_cn_cnm1:\n  - [1.0, 0.0, 0.0, " + x +
         "]\n  - [0.0, 1.0, 0.0, 0.0]\n  - [0.0, 0.0, 1.0, 0.0]\n  - [0.0, 0.0, 0.0, 1.0]\n" + camera;
}

class Folder : public ::testing::Test {
 protected:
  void add_images(const std::string& left, const std::string& right) {
    for (const char* name : {"/a_9.png", "/a_10.png"}) {
      test::write_image(folder_.file(left + name), 5);
      test::write_image(folder_.file(right + name), 6);
    }
  }
  void add_text(const std::string& name, const std::string& text) { test::write_text(folder_.file(name), text); }
  Result<Dataset> open(const std::string& sequence = "") {
    return open_dataset({.layout = DatasetLayout::kFolder, .path = folder_.path(), .sequence = sequence});
  }
  void expect_error(ErrorCode code, const std::string& what) {
    const auto dataset = open();
    ASSERT_FALSE(dataset) << "expected: " << what;
    EXPECT_EQ(dataset.error().code, code) << dataset.error().message;
    EXPECT_THAT(dataset.error().message, HasSubstr(what));
  }
  kinetrace::test::TempFolder folder_;
};

TEST_F(Folder, ReadsAnOpencvCalibrationOfOneFile) {
  add_images("left", "right");
  add_text("stereo.yml", "%YAML:1.0\n---\nimageSize: [48, 32]\n" + opencv_intrinsics("K", "D") +
                             opencv_extrinsics("-0.2, 0.001, 0.002"));
  const auto dataset = open();
  ASSERT_TRUE(dataset) << dataset.error().message;
  const RigCalibration& rig = dataset->calibration;
  EXPECT_EQ(rig.left.fx_px, 40);
  EXPECT_EQ(rig.left.distortion[4], 0.003);
  EXPECT_EQ(rig.right.fy_px, 43);
  EXPECT_EQ(rig.right.cx_px, 25);
  EXPECT_TRUE(rig.T_right_left.translation.isApprox(Eigen::Vector3d(-0.2, 0.001, 0.002)));
  EXPECT_EQ(dataset->frames[0].name(), "a_9");
  EXPECT_EQ(dataset->frames[1].frame_index, 10);
}

TEST_F(Folder, ReadsAnOpencvCalibrationOfTwoFilesWithoutSize) {
  add_images("image_0", "image_1");
  add_text("intrinsics.yml", "%YAML:1.0\n---\n" + opencv_intrinsics("M", "D"));
  add_text("extrinsics.yml",
           "%YAML:1.0\n---\n" + opencv_extrinsics("-0.2, 0., 0.") + matrix("R1", 3, 3, "1, 0, 0, 0, 1, 0, 0, 0, 1"));
  const auto dataset = open();
  ASSERT_TRUE(dataset) << dataset.error().message;
  EXPECT_EQ(dataset->calibration.left.width_px, 48);
  EXPECT_THAT(dataset->calibration.source, HasSubstr("extrinsics.yml, "));
  EXPECT_NEAR(Rectifier::rectified_geometry(dataset->calibration, {})->baseline_m, 0.2, 1e-9);
}

TEST_F(Folder, RefusesTwoOpencvCalibrationsThatSayTheSameThing) {
  add_images("image_0", "image_1");
  const std::string intrinsics = "%YAML:1.0\n---\n" + opencv_intrinsics("K", "D");
  add_text("stereo.yml", intrinsics + opencv_extrinsics("-0.2, 0., 0."));
  add_text("old.yml", intrinsics + opencv_extrinsics("-0.1, 0., 0."));
  expect_error(ErrorCode::kBadCalibration, "both hold K1");
  add_text("old.yml", "%YAML:1.0\n---\n" + opencv_extrinsics("-0.1, 0., 0."));
  expect_error(ErrorCode::kBadCalibration, "both hold R");
}

TEST_F(Folder, ReadsAnOpencvFisheyeCalibration) {
  add_images("left", "right");
  add_text("stereo.yaml", "%YAML:1.0\n---\ndistortion_model: fisheye\n" + matrix("K1", 3, 3, "40,0,24,0,40,16,0,0,1") +
                              matrix("D1", 4, 1, "0.01,0,0,0") + matrix("K2", 3, 3, "40,0,24,0,40,16,0,0,1") +
                              matrix("D2", 4, 1, "0.01,0,0,0") + opencv_extrinsics("-0.2, 0, 0"));
  const auto dataset = open();
  ASSERT_TRUE(dataset) << dataset.error().message;
  EXPECT_EQ(dataset->calibration.right.lens, LensModel::kEquidistant);
}

TEST_F(Folder, ReadsAKalibrCamchain) {
  add_images("cam0/data", "cam1/data");
  add_text("camchain-rig.yaml", kalibr("equidistant", "-0.11"));
  auto dataset = open();
  ASSERT_TRUE(dataset) << dataset.error().message;
  EXPECT_EQ(dataset->calibration.left.lens, LensModel::kEquidistant);
  EXPECT_EQ(dataset->calibration.left.distortion[3], 0.004);
  EXPECT_EQ(dataset->calibration.T_right_left.translation.x(), -0.11);
  add_text("camchain-rig.yaml", kalibr("radtan", "-0.11"));
  dataset = open();
  ASSERT_TRUE(dataset);
  EXPECT_EQ(dataset->calibration.left.lens, LensModel::kRadialTangential);
  add_text("camchain-rig.yaml", kalibr("fov", "-0.11"));
  expect_error(ErrorCode::kBadCalibration, "'cam0.distortion_model' is 'fov'");
  add_text("camchain-rig.yaml", kalibr("radtan", "0.11"));
  expect_error(ErrorCode::kBadCalibration, "left and right look swapped");
  add_text("camchain-rig.yaml", kalibr("radtan", ".nan"));
  expect_error(ErrorCode::kBadCalibration, "'cam1.T_cn_cnm1' holds nan");
}

TEST_F(Folder, ReadsAPairOfRosCameraInfos) {
  add_images("left", "right");
  add_text("left.yaml", ros_camera("0"));
  add_text("right.yaml", ros_camera("-7.6"));
  const auto dataset = open();
  ASSERT_TRUE(dataset) << dataset.error().message;
  ASSERT_TRUE(dataset->calibration.given);
  const StereoGeometry geometry = Rectifier::rectified_geometry(dataset->calibration, {}).value();
  EXPECT_NEAR(geometry.baseline_m, 0.2, 1e-12);
  EXPECT_EQ(geometry.fx_px, 38);
  EXPECT_EQ(geometry.cx_px, 23);
}

TEST_F(Folder, ReportsRosProblems) {
  add_images("left", "right");
  add_text("left.yaml", ros_camera("0"));
  expect_error(ErrorCode::kBadCalibration, "one file per view");
  add_text("right.yaml", ros_camera("-7.6", "thin"));
  expect_error(ErrorCode::kBadCalibration, "'distortion_model' is 'thin'");
}

TEST_F(Folder, IsReadWithoutACalibrationWhereNoneIsNeeded) {
  add_images("left", "right");
  add_text("broken.yaml", "K1: [");
  const auto dataset = open_dataset({.layout = DatasetLayout::kFolder, .path = folder_.path(), .uncalibrated = true});
  ASSERT_TRUE(dataset) << dataset.error().message;
  EXPECT_EQ(dataset->calibration.raw_width_px(), 48);
  EXPECT_EQ(dataset->calibration.raw_height_px(), 32);
  EXPECT_EQ(dataset->calibration.source, "images without calibration");
}

TEST_F(Folder, HiddenFilesAreNoImages) {
  add_images("left", "right");
  add_text("left/._a_9.png", "of macOS");
  add_text("right/.a_10.pgm", "hidden");
  add_text("camchain.yaml", kalibr("radtan", "-0.5"));
  const auto dataset = open();
  ASSERT_TRUE(dataset) << dataset.error().message;
  EXPECT_EQ(dataset->frames.size(), 2U);
}

TEST_F(Folder, SaysWhatItLookedFor) {
  expect_error(ErrorCode::kNotFound, "looked for left + right, image_0 + image_1, cam0 + cam1");
  add_images("left", "right");
  expect_error(ErrorCode::kNotFound, "no calibration: looked in " + folder_.path().string() + " for an OpenCV stereo");
  add_text("notes.yaml", "weather: fine\n");
  expect_error(ErrorCode::kNotFound, "no calibration");
}

TEST_F(Folder, RefusesToGuessBetweenCalibrations) {
  add_images("left", "right");
  add_text("a.yaml", kalibr("radtan", "-0.1"));
  add_text("b.yaml", "%YAML:1.0\n---\n" + opencv_intrinsics("K", "D") + opencv_extrinsics("-0.2, 0, 0"));
  expect_error(ErrorCode::kBadCalibration, "holds several calibrations: a.yaml, b.yaml; keep one");
}

TEST_F(Folder, TakesOneCalibrationInTwoForms) {
  add_images("left", "right");
  add_text("camchain.yaml", kalibr("radtan", "-0.1"));
  const auto alone = open();
  ASSERT_TRUE(alone) << alone.error().message;
  const std::filesystem::path other = folder_.path() / "calibration.yaml";
  ASSERT_TRUE(write_rig_calibration(alone->calibration, other, CalibrationFormat::kOpencv));
  const auto both = open();
  ASSERT_TRUE(both) << both.error().message;
  EXPECT_EQ(both->calibration.source, other.string());
  EXPECT_EQ(both->calibration.right.fx_px, alone->calibration.right.fx_px);
  add_text("camchain.yaml", kalibr("radtan", "-0.2"));
  expect_error(ErrorCode::kBadCalibration, "holds several calibrations: camchain.yaml, calibration.yaml; keep one");
}

TEST_F(Folder, ReportsOpencvProblems) {
  add_images("left", "right");
  const std::string head = "%YAML:1.0\n---\n";
  add_text("s.yaml", head + opencv_intrinsics("K", "D"));
  expect_error(ErrorCode::kBadCalibration, "'R' is missing");
  add_text("s.yaml", head + opencv_intrinsics("K", "X") + opencv_extrinsics("-0.2, 0, 0"));
  expect_error(ErrorCode::kBadCalibration, "'D1' is missing (looked for D1, distCoeffs1");
  add_text("s.yaml", head + opencv_intrinsics("K", "D") + opencv_extrinsics("-200, 0, 0"));
  expect_error(ErrorCode::kBadCalibration, "millimetres");
  add_text("s.yaml", head + "imageSize: [640, 480]\n" + opencv_intrinsics("K", "D") + opencv_extrinsics("-0.2, 0, 0"));
  expect_error(ErrorCode::kBadCalibration, "is for images of 640x480, but those in");
  add_text("s.yaml", head + "K1: [1\n");
  expect_error(ErrorCode::kBadCalibration, "s.yaml: is no valid YAML");
}

TEST_F(Folder, RejectsCoefficientsItCannotModel) {
  add_images("left", "right");
  std::string text = "%YAML:1.0\n---\n" + opencv_intrinsics("K", "D") + opencv_extrinsics("-0.2, 0, 0");
  const std::string five = "-0.11, 0.02, 0., 0., 0.";
  const auto with = [&](const std::string& data) {
    std::string changed = text;
    changed.replace(changed.find(five), five.size(), data);
    add_text("s.yaml", changed);
  };
  with("0, 0, 0, 0, 0, 0, 0, 0, 0.1, 0, 0, 0");
  expect_error(ErrorCode::kBadCalibration, "'D2' has more than 8 coefficients");
  with("0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0");
  EXPECT_TRUE(open());
  with("0, 0, 0");
  expect_error(ErrorCode::kBadCalibration, "'D2' must be 4, 5 or 8 numbers, got 3");
}

TEST_F(Folder, TakesTimesFromFileNamesOrATimesFile) {
  add_text("s.yaml", kalibr("none", "-0.1"));
  for (const char* name : {"1403715273262142976", "1403715273312142976"}) {
    test::write_image(folder_.file(std::string("left/") + name + ".png"), 5);
    test::write_image(folder_.file(std::string("right/") + name + ".png"), 5);
  }
  const auto by_name = open();
  ASSERT_TRUE(by_name) << by_name.error().message;
  EXPECT_EQ(by_name->frames[1].timestamp_ns, 1403715273312142976);
  EXPECT_EQ(by_name->frames[1].frame_index, 1);
  std::filesystem::remove_all(folder_.path() / "left");
  std::filesystem::remove_all(folder_.path() / "right");
  add_images("left", "right");
  add_text("times.txt", "0.5\n0.75\n");
  const auto by_file = open();
  ASSERT_TRUE(by_file) << by_file.error().message;
  EXPECT_EQ(by_file->frames[0].timestamp_ns, 500'000'000);
}

// Images of these names, without a list of times.
class Named : public Folder {
 protected:
  Result<Dataset> open_named(const std::vector<std::string>& names) {
    for (const char* side : {"left", "right"}) {
      std::filesystem::remove_all(folder_.path() / side);
      for (const std::string& name : names) {
        test::write_image(folder_.file(std::string(side) + "/" + name + ".png"), 5);
      }
    }
    add_text("s.yaml", kalibr("none", "-0.1"));
    return open();
  }
  /// Number and time of the second frame.
  std::pair<std::int64_t, std::int64_t> second(const std::vector<std::string>& names) {
    const auto dataset = open_named(names);
    EXPECT_TRUE(dataset) << dataset.error().message;
    return dataset ? std::pair(dataset->frames[1].frame_index, dataset->frames[1].timestamp_ns) : std::pair(-1L, -1L);
  }
};

TEST_F(Named, DatesAreTimes) {
  EXPECT_EQ(second({"img_20260101123057", "img_20260101123059", "img_20260101123101"}),
            std::pair(1L, 1767270659000000000L));
  EXPECT_EQ(second({"20260101123057100", "20260101123057200"}), std::pair(1L, 1767270657200000000L));
}

TEST_F(Named, DigitsAreTimesOnlyAtStepsThatACameraHas) {
  EXPECT_EQ(second({"1399381444704913", "1399381444767413"}), std::pair(1L, 1399381444767413000L)) << "microseconds";
  EXPECT_EQ(second({"0000000000000011", "0000000000000012"}), std::pair(12L, 1'200'000'000L)) << "a frame number";
  EXPECT_EQ(second({"00000000000001", "00000000000002"}), std::pair(2L, 200'000'000L)) << "no date";
}

TEST_F(Named, WhatIsNoFrameNumberIsNumberedInOrder) {
  for (const std::vector<std::string>& names : {std::vector<std::string>{"4000000000", "4000000001"},
                                                {"2147483646", "2147483647"},
                                                {"4611686018427387904", "9223372036854775807"},
                                                {"99999999999999999998", "99999999999999999999"}}) {
    const auto dataset = open_named(names);
    ASSERT_TRUE(dataset) << dataset.error().message;
    EXPECT_EQ(dataset->frames[1].frame_index, 1);
    EXPECT_EQ(dataset->frames[1].timestamp_ns, 100'000'000);
    EXPECT_THAT(dataset->notes, Contains(HasSubstr("left: the names of the images hold no frame numbers up to")));
  }
}

TEST_F(Named, AListOfTimesComesBeforeTheNames) {
  add_text("times.txt", "7\n7.5\n");
  EXPECT_EQ(second({"20260101123057", "20260101123058"}), std::pair(1L, 7'500'000'000L));
  EXPECT_EQ(second({"4000000000", "4000000001"}), std::pair(1L, 7'500'000'000L));
  add_text("times.txt", "7\n7.5\n8\n");
  EXPECT_FALSE(open_named({"4000000000", "4000000001"})) << "which of them?";
  const auto by_name = open_named({"1403715273262142976", "1403715273312142976"});
  ASSERT_TRUE(by_name) << by_name.error().message;
  EXPECT_EQ(by_name->frames[1].timestamp_ns, 1403715273312142976);
  EXPECT_THAT(by_name->notes, Contains(HasSubstr("times.txt: has 3 times for 2 frames")));
}

TEST_F(Folder, FindsSequencesBelow) {
  for (const char* side : {"left", "right"}) {
    test::write_image(folder_.file(std::string("run2/") + side + "/0.png"), 5);
  }
  add_text("run2/s.yaml", kalibr("radtan", "-0.1"));
  EXPECT_EQ(open("run2")->name, "run2");
  EXPECT_THAT(open("run3").error().message, HasSubstr("no sequence 'run3'; choose one with --sequence: run2"));
}

}  // namespace
}  // namespace kinetrace::hal
