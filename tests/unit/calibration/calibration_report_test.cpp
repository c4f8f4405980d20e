#include "calibration_report.hpp"

#include <filesystem>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "board_scene.hpp"
#include "temp_folder.hpp"

namespace kinetrace::calibration {
namespace {

namespace fs = std::filesystem;
using ::testing::HasSubstr;

TEST(CalibrationReport, IsWrittenForARecordingWhoseNameIsNotUtf8) {
  const Target target = chessboard_target(9, 6, 0.03);
  const ViewCollector views(target, Lens::kRadialTangential, 640, 480);
  const std::string json = report_json({}, views, {.images = "folder:bd\xff", .target = "board", .lens = "radtan"});
  EXPECT_THAT(json, HasSubstr("\"images\": \"folder:bd\xef\xbf\xbd\""));
}

TEST(OutputFolder, IsMadeOnlyWhenThereAreFilesForIt) {
  const kinetrace::test::TempFolder folder;
  const fs::path out = folder.path() / "of" / "today";
  ASSERT_TRUE(check_output_folder(out));
  EXPECT_FALSE(fs::exists(out.parent_path()));
  ASSERT_TRUE(write_calibration_files(test::true_rig(Lens::kRadialTangential), out, {}));
  EXPECT_TRUE(fs::exists(out / "calibration.yaml"));
  ASSERT_TRUE(check_output_folder(out));
  EXPECT_TRUE(fs::exists(out / "calibration.yaml"));
  const Status obstructed = check_output_folder(out / "calibration.yaml");
  ASSERT_FALSE(obstructed);
  EXPECT_THAT(obstructed.error().message, HasSubstr("name another folder for the calibration"));
}

}  // namespace
}  // namespace kinetrace::calibration
