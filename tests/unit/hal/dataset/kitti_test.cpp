// The three KITTI layouts.
#include <filesystem>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "kinetrace/hal/dataset.hpp"
#include "kinetrace/hal/rectifier.hpp"
#include "recording_for_test.hpp"

namespace kinetrace::hal {
namespace {

using ::testing::HasSubstr;

constexpr int kRawWidth = 60;
constexpr int kRawHeight = 40;

std::string raw_camera(const std::string& id, const std::string& offset) {
  return "S_" + id + ": 6.0e+01 4.0e+01\nK_" + id + ": 50 0 30 0 50 20 0 0 1\nD_" + id + ": -0.1 0.01 0 0 0\nR_" + id +
         ": 1 0 0 0 1 0 0 0 1\nT_" + id + ": 0 0 0\nS_rect_" + id + ": 48 32\nR_rect_" + id +
         ": 1 0 0 0 1 0 0 0 1\nP_rect_" + id + ": 40 0 24 " + offset + " 0 40 16 0 0 0 1 0\n";
}

std::string raw_calibration() {
  return "calib_time: 09-Jan-2012 13:57:47\ncorner_dist: 9.95e-02\n" + raw_camera("00", "0") + raw_camera("01", "-20") +
         raw_camera("02", "2.4") + raw_camera("03", "-18.8");
}

class KittiRaw : public ::testing::Test {
 protected:
  KittiRaw() { test::write_text(folder_.file("2011_09_26/calib_cam_to_cam.txt"), raw_calibration()); }
  std::filesystem::path add_drive(const std::string& name, int width, int height, bool color = false) {
    const std::string drive = "2011_09_26/" + name;
    const std::string views[] = {color ? "/image_02" : "/image_00", color ? "/image_03" : "/image_01"};
    for (const std::string& view : views) {
      test::write_image(folder_.file(drive + view + "/data/0000000000.png"), 1, width, height);
      test::write_image(folder_.file(drive + view + "/data/0000000001.png"), 1, width, height);
      test::write_text(folder_.file(drive + view + "/timestamps.txt"),
                       "2011-09-26 14:06:03.300000000\n2011-09-26 14:06:03.403100001\n");
    }
    return folder_.path() / drive;
  }
  static Result<Dataset> open(const std::filesystem::path& path, const std::string& sequence = "",
                              CameraChoice cameras = CameraChoice::kAuto) {
    return open_dataset({.layout = DatasetLayout::kKittiRaw, .path = path, .sequence = sequence, .cameras = cameras});
  }
  static void expect_error(const Result<Dataset>& dataset, ErrorCode code, const std::string& what) {
    ASSERT_FALSE(dataset) << "expected: " << what;
    EXPECT_EQ(dataset.error().code, code) << dataset.error().message;
    EXPECT_THAT(dataset.error().message, HasSubstr(what));
  }
  kinetrace::test::TempFolder folder_;
};

TEST_F(KittiRaw, SyncDrivesAreRectified) {
  const auto dataset = open(add_drive("2011_09_26_drive_0001_sync", 48, 32));
  ASSERT_TRUE(dataset) << dataset.error().message;
  ASSERT_TRUE(dataset->calibration.rectified);
  EXPECT_DOUBLE_EQ(dataset->calibration.rectified->baseline_m, 0.5);
  EXPECT_EQ(dataset->calibration.rectified->width_px, 48);
  EXPECT_EQ(dataset->name, "2011_09_26_drive_0001_sync");
  EXPECT_EQ(dataset->frames[1].timestamp_ns - dataset->frames[0].timestamp_ns, 103100001);
}

TEST_F(KittiRaw, TimesOfTheCamerasThatDisagreeAreNoted) {
  const std::filesystem::path drive = add_drive("2011_09_26_drive_0001_sync", 48, 32);
  const std::filesystem::path right = drive / "image_01" / "timestamps.txt";
  test::write_text(right, "2011-09-26 14:06:03.301000000\n2011-09-26 14:06:03.404100001\n");
  EXPECT_THAT(open(drive)->notes, ::testing::IsEmpty()) << "a millisecond is how cameras are";
  test::write_text(right, "2011-09-26 14:06:03.300000000\n2011-09-26 14:06:03.503100001\n");
  EXPECT_THAT(open(drive)->notes,
              ::testing::ElementsAre(HasSubstr("image_01/timestamps.txt: 1 of 2 times are more than a quarter")));
  test::write_text(right, "2011-09-26 14:06:03.300000000\n");
  EXPECT_THAT(open(drive)->notes, ::testing::ElementsAre(HasSubstr("has 1 times, the left camera's has 2")));
  test::write_text(right, "yesterday\n");
  EXPECT_THAT(open(drive)->notes, ::testing::ElementsAre(HasSubstr("could not be compared")));
}

TEST_F(KittiRaw, ExtractDrivesAreRawAndComeWithTheirRectification) {
  const auto dataset = open(add_drive("2011_09_26_drive_0001_extract", kRawWidth, kRawHeight));
  ASSERT_TRUE(dataset) << dataset.error().message;
  ASSERT_TRUE(dataset->calibration.given);
  EXPECT_EQ(dataset->calibration.raw_width_px(), kRawWidth);
  EXPECT_EQ(dataset->calibration.left.distortion[0], -0.1);
  const StereoGeometry geometry = Rectifier::rectified_geometry(dataset->calibration, {}).value();
  EXPECT_EQ(geometry.width_px, 48);
  EXPECT_DOUBLE_EQ(geometry.baseline_m, 0.5);
}

TEST_F(KittiRaw, ColourCamerasHaveTheirOwnBaseline) {
  const auto drive = add_drive("2011_09_26_drive_0001_sync", 48, 32, true);
  const auto dataset = open(drive);
  ASSERT_TRUE(dataset) << dataset.error().message;
  EXPECT_DOUBLE_EQ(dataset->calibration.rectified->baseline_m, 0.53);
  expect_error(open(drive, "", CameraChoice::kGray), ErrorCode::kNotFound, "looked for image_00 and image_01");
}

TEST_F(KittiRaw, FindsADriveByDateFolderAndNumber) {
  add_drive("2011_09_26_drive_0001_sync", 48, 32);
  const auto only = open(folder_.path() / "2011_09_26");
  ASSERT_TRUE(only) << only.error().message;
  add_drive("2011_09_26_drive_0002_sync", 48, 32);
  expect_error(open(folder_.path() / "2011_09_26"), ErrorCode::kInvalidArgument,
               "2011_09_26_drive_0001_sync, 2011_09_26_drive_0002_sync");
  EXPECT_EQ(open(folder_.path() / "2011_09_26", "0002")->name, "2011_09_26_drive_0002_sync");
  EXPECT_EQ(open(folder_.path(), "2011_09_26_drive_0002_sync")->name, "2011_09_26_drive_0002_sync");
  const auto as_listed = open(folder_.path(), "2011_09_26/2011_09_26_drive_0002_sync");
  ASSERT_TRUE(as_listed) << as_listed.error().message;
  EXPECT_EQ(as_listed->name, "2011_09_26_drive_0002_sync");
  expect_error(open(folder_.path(), "0003"), ErrorCode::kInvalidArgument, "no drive '0003'");
}

TEST_F(KittiRaw, SaysWhereItLookedForTheCalibration) {
  const auto drive = add_drive("2011_09_26_drive_0001_sync", 48, 32);
  std::filesystem::remove(folder_.path() / "2011_09_26/calib_cam_to_cam.txt");
  expect_error(open(drive), ErrorCode::kNotFound,
               "no calibration: looked for calib_cam_to_cam.txt in " + drive.string());
  expect_error(open(folder_.path()), ErrorCode::kNotFound, "no calibration");
}

TEST_F(KittiRaw, RejectsImagesOfAnotherCamera) {
  expect_error(open(add_drive("2011_09_26_drive_0001_sync", 50, 32)), ErrorCode::kBadCalibration,
               "is for images of 60x40 (raw) or 48x32 (rectified), but these are 50x32");
}

TEST_F(KittiRaw, RejectsDamagedCalibrations) {
  const auto drive = add_drive("2011_09_26_drive_0001_sync", 48, 32);
  const std::string path = folder_.file("2011_09_26/calib_cam_to_cam.txt");
  const auto with = [&path](const std::string& from, const std::string& to) {
    std::string text = raw_calibration();
    text.replace(text.find(from), from.size(), to);
    test::write_text(path, text);
  };
  with("P_rect_01: 40", "P_rect_01: nan");
  expect_error(open(drive), ErrorCode::kBadCalibration, path + ": 'P_rect_01' holds nan");
  with("P_rect_01: 40", "P_rect_01:");
  expect_error(open(drive), ErrorCode::kBadCalibration, path + ": 'P_rect_01' must be 12 numbers");
  with("P_rect_01", "Q_rect_01");
  expect_error(open(drive), ErrorCode::kBadCalibration, path + ": 'P_rect_01' is missing");
  with("S_01:", "S_00:");
  expect_error(open(drive), ErrorCode::kBadCalibration, path + ": 'S_00' is there twice");
  with("24 -20 0", "24 20 0");
  expect_error(open(drive), ErrorCode::kBadCalibration, "left and right look swapped");
  with("24 -20 0", "24 0 0");
  expect_error(open(drive), ErrorCode::kBadCalibration, "missing or zero");
}

TEST(KittiOdometry, OpensASequenceByNameAndListsThem) {
  const test::Recording recording(1);
  const auto root = recording.path().parent_path();
  const auto open = [&root](const std::string& sequence) {
    return open_dataset({.layout = DatasetLayout::kKittiOdometry, .path = root, .sequence = sequence});
  };
  EXPECT_TRUE(open(""));
  EXPECT_TRUE(open("sequence"));
  const auto missing = open("07");
  ASSERT_FALSE(missing);
  EXPECT_EQ(missing.error().code, ErrorCode::kInvalidArgument);
  EXPECT_THAT(missing.error().message, HasSubstr("no sequence '07'; choose one with --sequence: sequence"));
}

TEST(KittiOdometry, NamesTheViewItMisses) {
  const test::Recording recording(1);
  std::filesystem::remove_all(recording.path() / "image_1");
  const auto opened = open_dataset({.layout = DatasetLayout::kKittiOdometry, .path = recording.path()});
  ASSERT_FALSE(opened);
  EXPECT_THAT(opened.error().message, HasSubstr((recording.path() / "image_1").string() + ": no such folder"));
}

TEST(KittiOdometry, NamesTheCalibrationItMisses) {
  const test::Recording recording(1);
  std::filesystem::remove(recording.path() / "calib.txt");
  const auto dataset = recording.open();
  ASSERT_FALSE(dataset);
  EXPECT_EQ(dataset.error().code, ErrorCode::kNotFound);
  EXPECT_THAT(dataset.error().message, HasSubstr((recording.path() / "calib.txt").string()));
}

class KittiTracking : public ::testing::Test {
 protected:
  KittiTracking() {
    for (const char* view : {"image_02", "image_03"}) {
      for (const char* name : {"/0003/000000.png", "/0003/000001.png"}) {
        test::write_color_image(folder_.file(std::string("training/") + view + name), 9);
      }
    }
    test::write_text(folder_.file("training/calib/0003.txt"),
                     test::kitti_projections() + "R_rect 1 0 0 0 1 0 0 0 1\nTr_velo_cam 1 0 0 0 0 1 0 0 0 0 1 0\n");
  }
  Result<Dataset> open(const std::string& below, const std::string& sequence,
                       CameraChoice cameras = CameraChoice::kAuto) {
    return open_dataset({.layout = DatasetLayout::kKittiTracking,
                         .path = folder_.path() / below,
                         .sequence = sequence,
                         .cameras = cameras});
  }
  kinetrace::test::TempFolder folder_;
};

TEST_F(KittiTracking, OpensASequenceAtTenHertz) {
  for (const char* below : {"", "training"}) {
    const auto dataset = open(below, "0003");
    ASSERT_TRUE(dataset) << dataset.error().message;
    EXPECT_EQ(dataset->name, "0003");
    EXPECT_DOUBLE_EQ(dataset->calibration.rectified->baseline_m, 0.53);
    EXPECT_EQ(dataset->frames[1].timestamp_ns, 100'000'000);
  }
}

TEST_F(KittiTracking, ReportsWhatIsMissing) {
  EXPECT_EQ(open("", "0003", CameraChoice::kGray).error().code, ErrorCode::kInvalidArgument);
  EXPECT_THAT(open("training", "0004").error().message,
              HasSubstr("no sequence '0004'; choose one with --sequence: 0003"));
  std::filesystem::remove(folder_.path() / "training/calib/0003.txt");
  const auto dataset = open("", "0003");
  ASSERT_FALSE(dataset);
  EXPECT_EQ(dataset.error().code, ErrorCode::kNotFound);
  EXPECT_THAT(dataset.error().message, HasSubstr("training/calib/0003.txt"));
}

}  // namespace
}  // namespace kinetrace::hal
