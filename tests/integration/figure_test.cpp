// The command `kinetrace figure` as a user meets it.
#include <algorithm>
#include <filesystem>
#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "kinetrace/imaging/image_info.hpp"
#include "program.hpp"
#include "small_recording.hpp"
#include "temp_folder.hpp"

namespace kinetrace::test {
namespace {

using ::testing::HasSubstr;
using ::testing::IsEmpty;

class Figure : public ::testing::Test {
 protected:
  void SetUp() override {
    recording_.write();
    const ProgramResult run = run_kinetrace(
        {"run", "--dataset", recording_.dataset(), "--segmentation", "motion", "--quiet", "--out", run_.string()});
    ASSERT_EQ(run.exit_code, 0) << run.err;
  }
  [[nodiscard]] ProgramResult figure(std::vector<std::string> more = {}) const {
    more.insert(more.begin(), {"figure", run_.string()});
    return run_kinetrace(more);
  }
  static void expect_size(const std::filesystem::path& png, int width, int least_height) {
    const auto info = imaging::read_image_info(png.c_str());
    ASSERT_TRUE(info) << info.error().message;
    EXPECT_EQ(info->format, imaging::ImageFormat::kPng);
    EXPECT_EQ(info->width, width);
    EXPECT_GE(info->height, least_height);
    EXPECT_EQ(info->channels, 3);
  }

  TempFolder scratch_;
  SmallRecording recording_{.root = scratch_.path() / "recording"};
  std::filesystem::path run_ = scratch_.path() / "run";
};

TEST_F(Figure, IsAPngOf1600PixelsInTheRunFolder) {
  const ProgramResult result = figure();
  ASSERT_EQ(result.exit_code, 0) << result.err;
  EXPECT_THAT(result.err, IsEmpty());
  EXPECT_THAT(result.out, HasSubstr((run_ / "figure.png").string()));
  expect_size(run_ / "figure.png", 1600, 1200);
}

TEST_F(Figure, GoesWhereItIsTold) {
  const std::filesystem::path file = scratch_.path() / "mine.png";
  const ProgramResult result = figure({"--frame", "2", "--out", file.string(), "--quiet"});
  ASSERT_EQ(result.exit_code, 0) << result.err;
  EXPECT_THAT(result.out, IsEmpty());
  expect_size(file, 1600, 1200);
  EXPECT_FALSE(std::filesystem::exists(run_ / "figure.png"));
}

TEST_F(Figure, OverlayIsAPictureOfEachFrame) {
  const std::filesystem::path overlay = scratch_.path() / "overlay";
  const ProgramResult result = figure({"--overlay", overlay.string()});
  ASSERT_EQ(result.exit_code, 0) << result.err;
  EXPECT_THAT(result.out, HasSubstr(std::to_string(recording_.frames) + " pictures in"));
  for (int i = 0; i < recording_.frames; ++i) {
    expect_size(overlay / recording_.image(0, i).filename(), SmallRecording::kWidth, SmallRecording::kHeight);
  }
}

TEST_F(Figure, WithoutItsRecordingIsDrawnWithAWarning) {
  std::filesystem::remove_all(recording_.root);
  const ProgramResult result = figure();
  EXPECT_EQ(result.exit_code, 0) << result.err;
  EXPECT_THAT(result.err, HasSubstr("--dataset LAYOUT:PATH"));
  expect_size(run_ / "figure.png", 1600, 1200);
  // An overlay is nothing without.
  EXPECT_EQ(figure({"--overlay", (scratch_.path() / "overlay").string()}).exit_code, 66);
}

TEST_F(Figure, WrongUseIsSaidInOneLine) {
  const auto expect = [&](const std::vector<std::string>& arguments, int exit_code, const std::string& message) {
    const ProgramResult result = run_kinetrace(arguments);
    EXPECT_EQ(result.exit_code, exit_code) << result.err;
    EXPECT_THAT(result.err, HasSubstr(message));
    EXPECT_EQ(std::count(result.err.begin(), result.err.end(), '\n'), 1) << result.err;
  };
  const std::string run = run_.string();
  expect({"figure"}, 64, "RUN");
  expect({"figure", run, "--frame", "6"}, 64, "frames 0 to 5");
  expect({"figure", run, "--frame", "six"}, 64, "--frame");
  expect({"figure", run, "--object", "77"}, 64, "--object 77");
  expect({"figure", run, "--dataset", "nothing"}, 64, "LAYOUT:PATH");
  expect({"figure", run, "--dataset", "kitti-odometry:" + scratch_.path().string()}, 66, scratch_.path().string());
  expect({"figure", scratch_.path().string()}, 66, "run.json");
  expect({"figure", run, "--out", "/no/such/folder/x.png"}, 74, "/no/such/folder/x.png");
}

}  // namespace
}  // namespace kinetrace::test
