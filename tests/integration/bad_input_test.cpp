// Bad input from the field: a clear message with its exit code, or a counted skip; never a crash.
#include <algorithm>
#include <array>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <string>
#include <sys/stat.h>
#include <utility>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "program.hpp"
#include "small_recording.hpp"
#include "temp_folder.hpp"

namespace kinetrace::test {
namespace {

using ::testing::HasSubstr;

class BadInput : public ::testing::Test {
 protected:
  ProgramResult run(std::vector<std::string> more = {}) {
    std::vector<std::string> arguments{"run", "--dataset", recording_.dataset(), "--out", out_.string(), "--quiet"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return run_kinetrace(arguments);
  }
  /// Runs; expects one line on standard error that holds `culprit`, and this exit code.
  void expect_error(int exit_code, const std::string& culprit, const std::vector<std::string>& more = {}) {
    const ProgramResult result = run(more);
    expect_refusal(result, exit_code, culprit);
  }
  /// Runs; expects success and gives back run.json. Warnings go to `warnings_`.
  nlohmann::json expect_success(const std::vector<std::string>& more = {}) {
    const ProgramResult result = run(more);
    EXPECT_EQ(result.exit_code, 0) << result.err;
    warnings_ = result.err;
    std::ifstream file(out_ / "run.json");
    return nlohmann::json::parse(file, nullptr, false);
  }
  void remove_right_images() { std::filesystem::remove_all(recording_.sequence() / "image_1"); }

  TempFolder scratch_;
  SmallRecording recording_{.root = scratch_.path() / "recording"};
  std::filesystem::path out_ = scratch_.path() / "out";
  std::string warnings_;
};

TEST_F(BadInput, MissingFolder) {
  expect_error(kNoInput, recording_.sequence().string());
}

TEST_F(BadInput, ANameThatATerminalWouldObeyIsWrittenOut) {
  recording_.root = scratch_.path() / "\x1b[31mred\x1b]0;title\x07";
  expect_error(kNoInput, "\\x1b[31mred\\x1b]0;title\\x07");
  recording_.write();
  std::ofstream(recording_.sequence() / "image_0" / "000001.png") << "damaged";
  expect_success();
  EXPECT_THAT(warnings_, ::testing::Not(HasSubstr("\x1b")));
}

TEST_F(BadInput, FolderWithoutImages) {
  std::filesystem::create_directories(recording_.sequence() / "image_0");
  std::filesystem::create_directories(recording_.sequence() / "image_1");
  recording_.write_calibration("0", "-150");
  expect_error(kNoInput, recording_.sequence().string());
}

TEST_F(BadInput, FolderWithoutTheRightSide) {
  recording_.write();
  remove_right_images();
  expect_error(kNoInput, recording_.sequence().string());
}

TEST_F(BadInput, MissingCalibration) {
  recording_.write();
  std::filesystem::remove(recording_.calibration());
  expect_error(kNoInput, "calib.txt");
}

TEST_F(BadInput, EmptyCalibration) {
  recording_.write();
  truncate_file(recording_.calibration(), 0);
  expect_error(kBadData, "calib.txt");
}

TEST_F(BadInput, CalibrationThatIsNotFinite) {
  recording_.write();
  recording_.write_calibration("0", "nan");
  expect_error(kBadData, "calib.txt");
}

TEST_F(BadInput, SwappedCalibration) {
  recording_.write();
  recording_.write_calibration("-150", "0");
  expect_error(kBadData, "calib.txt");
}

TEST_F(BadInput, NoBaseline) {
  recording_.write();
  recording_.write_calibration("0", "0");
  expect_error(kBadData, "calib.txt");
}

TEST_F(BadInput, CamerasOfDifferentSize) {
  recording_.write();
  for (int frame = 0; frame < recording_.frames; ++frame) {
    recording_.write_image_of_size(1, frame, SmallRecording::kWidth / 2, SmallRecording::kHeight);
  }
  expect_error(kBadData, recording_.sequence().string());
}

TEST_F(BadInput, NoImageIsReadable) {
  recording_.write();
  for (int frame = 0; frame < recording_.frames; ++frame) {
    truncate_file(recording_.image(0, frame), 0);
  }
  expect_error(kBadData, recording_.sequence().string());
}

TEST_F(BadInput, TruncatedImageIsSkippedAndCounted) {
  recording_.write();
  truncate_file(recording_.image(0, 2), std::filesystem::file_size(recording_.image(0, 2)) / 2);
  const nlohmann::json run = expect_success();
  EXPECT_EQ(run["counters"]["frames_skipped_unreadable"], 1);
  EXPECT_EQ(run["frames"], recording_.frames - 1);
  EXPECT_THAT(warnings_, HasSubstr(recording_.image(0, 2).string()));
}

TEST_F(BadInput, ZeroByteImageIsSkippedAndCounted) {
  recording_.write();
  truncate_file(recording_.image(1, 0), 0);
  const nlohmann::json run = expect_success();
  EXPECT_EQ(run["counters"]["frames_skipped_unreadable"], 1);
  EXPECT_THAT(warnings_, HasSubstr(recording_.image(1, 0).string()));
}

TEST_F(BadInput, HugeImageHeaderIsSkippedAndCounted) {
  recording_.write();
  forge_png_size(recording_.image(0, 3), 2000000000U, 2000000000U);
  const nlohmann::json run = expect_success();
  EXPECT_EQ(run["counters"]["frames_skipped_unreadable"], 1);
  EXPECT_THAT(warnings_, HasSubstr(recording_.image(0, 3).string()));
}

TEST_F(BadInput, ImageOfAnotherSizeIsSkippedAndCounted) {
  recording_.write();
  recording_.write_image_of_size(0, 3, SmallRecording::kWidth, SmallRecording::kHeight / 2);
  const nlohmann::json run = expect_success();
  EXPECT_EQ(run["counters"]["frames_skipped_unreadable"], 1);
  EXPECT_THAT(warnings_, HasSubstr(recording_.image(0, 3).string()));
}

TEST_F(BadInput, NamedPipeInPlaceOfAnImageIsSkippedAndCounted) {
  recording_.write();
  std::filesystem::remove(recording_.image(0, 2));
  ASSERT_EQ(::mkfifo(recording_.image(0, 2).c_str(), 0600), 0);
  const nlohmann::json run = expect_success();
  EXPECT_EQ(run["counters"]["frames_skipped_unreadable"], 1);
  EXPECT_THAT(warnings_, HasSubstr(recording_.image(0, 2).string() + ": is a named pipe"));
}

TEST_F(BadInput, OneCameraThatSeesNothingIsNamed) {
  recording_.write();
  recording_.uniform = true;
  for (int frame = 0; frame < recording_.frames; ++frame) {
    recording_.write_image_of_size(0, frame, SmallRecording::kWidth, SmallRecording::kHeight);
  }
  expect_error(kBadData, recording_.image(0, 0).string() + ": its lower 256 of 256 rows are of one value");
}

TEST_F(BadInput, ImagesTooSmallForFeatures) {
  for (const auto& [width, height] : {std::pair{1, 1}, {32, 32}, {63, 65}, {65, 47}}) {
    std::filesystem::remove_all(recording_.root);
    recording_.width_px = width;
    recording_.height_px = height;
    recording_.write();
    std::ofstream(recording_.calibration()) << "P0: 30 0 0 0 0 30 0 0 0 0 1 0\nP1: 30 0 0 -15 0 30 0 0 0 0 1 0\n";
    expect_error(kBadData, recording_.sequence().string() + ": its images of ");
  }
}

TEST_F(BadInput, TimesThatAreTwiceTheSameOrInAnotherUnit) {
  recording_.write();
  const std::filesystem::path times = recording_.sequence() / "times.txt";
  std::ofstream(times) << "0\n0.1\n0.1\n0.3\n0.4\n0.5\n";
  expect_error(kBadData, times.string() + ": frame 000002 does not come after");
  std::ofstream(times) << "0\n1e-7\n2e-7\n3e-7\n4e-7\n5e-7\n";
  expect_error(kBadData, times.string() + ": frames are 100 ns apart (median)");
}

TEST_F(BadInput, FramesLostBeforeTheFirstAreCountedFromIt) {
  recording_.write();
  for (const int frame : {0, 1}) {
    std::filesystem::remove(recording_.image(1, frame));
  }
  expect_success();
  EXPECT_THAT(warnings_, HasSubstr("frames_lost 2x since frame 2"));
}

TEST_F(BadInput, WhereNoFrameCanBeUsedTroublesAreSinceTheStart) {
  recording_.write();
  expect_error(kBadData, "none of its frames can be used", {"--fault", "corrupt@0-5"});
  std::ifstream file(out_ / "run.json");
  const nlohmann::json report = nlohmann::json::parse(file, nullptr, false);
  ASSERT_TRUE(report.is_object());
  EXPECT_THAT(report.at("warnings").dump(), HasSubstr("frames_damaged 6x since the start"));
}

TEST_F(BadInput, MissingSideIsSkippedAndCounted) {
  recording_.write();
  std::filesystem::remove(recording_.image(1, 4));
  const nlohmann::json run = expect_success();
  EXPECT_EQ(run["counters"]["frames_skipped_missing_side"], 1);
  EXPECT_EQ(run["frames"], recording_.frames - 1);
}

TEST_F(BadInput, SingleFrameGivesASinglePose) {
  recording_.frames = 1;
  recording_.write();
  const nlohmann::json run = expect_success();
  EXPECT_EQ(run["frames"], 1);
  std::ifstream poses(out_ / "camera_kitti.txt");
  EXPECT_EQ(std::count(std::istreambuf_iterator<char>(poses), {}, '\n'), 1);
}

TEST_F(BadInput, NothingToSeeIsReportedAsSuch) {
  recording_.uniform = true;
  for (const std::uint8_t brightness : std::array<std::uint8_t, 3>{0, 128, 255}) {
    SCOPED_TRACE("brightness " + std::to_string(brightness));
    recording_.brightness = brightness;
    recording_.write();
    const nlohmann::json run = expect_success({"--segmentation", "motion"});
    EXPECT_EQ(run["frames"], recording_.frames);
    EXPECT_GT(run["counters"]["background_lost_frames"], 0);
    EXPECT_NE(run["health"]["worst"], "ok");
    EXPECT_THAT(run["warnings"].dump(), HasSubstr("motion was found in 1 of 6 frames only"));
  }
}

TEST_F(BadInput, MissingMaskFolder) {
  recording_.write();
  expect_error(kNoInput, "no_such_masks", {"--segmentation", "masks:" + (scratch_.path() / "no_such_masks").string()});
}

TEST_F(BadInput, UnknownSegmentation) {
  recording_.write();
  expect_error(kUsage, "telepathy", {"--segmentation", "telepathy"});
}

TEST_F(BadInput, UnknownConfigurationKey) {
  recording_.write();
  const std::filesystem::path config = scratch_.path() / "mine.yaml";
  std::ofstream(config) << "# mine\nfeatures:\n  max_featurse: 100\n";
  expect_error(kConfig,
               config.string() + ":3: unknown key \"features.max_featurse\"; did you mean features.max_features?",
               {"--config", config.string()});
}

TEST_F(BadInput, MissingConfigurationFile) {
  recording_.write();
  expect_error(kNoInput, "nowhere.yaml", {"--config", "nowhere.yaml"});
}

TEST_F(BadInput, SettingOutOfRange) {
  recording_.write();
  expect_error(kConfig, "features.max_features", {"--set", "features.max_features=-1"});
}

TEST_F(BadInput, BudgetBelowThePlan) {
  recording_.write();
  expect_error(kConfig, "memory.budget_mib", {"--set", "memory.budget_mib=23"});
}

TEST_F(BadInput, RunFolderBelowAFile) {
  recording_.write();
  std::ofstream(scratch_.path() / "file") << "x";
  out_ = scratch_.path() / "file" / "out";
  expect_error(kCannotCreate, out_.string());
}

TEST_F(BadInput, RunFolderWithOtherThingsIsLeftAlone) {
  recording_.write();
  std::filesystem::create_directories(out_);
  std::ofstream(out_ / "thesis.txt") << "x";
  expect_error(kCannotCreate, out_.string());
  EXPECT_TRUE(std::filesystem::exists(out_ / "thesis.txt"));
}

}  // namespace
}  // namespace kinetrace::test
